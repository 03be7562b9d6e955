"""The command line: what it prints and saves, and one line for whatever the user got wrong."""

import re
import shlex
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from pysindy_evolve import cli, close_loop
from pysindy_evolve.cli import commands
from pysindy_evolve.datasets import friction_drive, nothing_missing
from pysindy_evolve.export.code import LANGUAGES


def save(path, **columns):
    table = np.column_stack(list(columns.values()))
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return str(path)


def save_drive(drive, folder):
    return [
        save(folder / f"{record.name}.csv", t=record.t, q=record.y, F=record.u)
        for record in (drive.train, drive.test)
    ]


def run(capsys, *arguments):
    """Exit code, stdout and stderr of one command."""
    try:
        code = cli.main(list(arguments))
    except SystemExit as ended:  # argparse ends by itself
        code = ended.code
    printed = capsys.readouterr()
    return code, printed.out, printed.err


@pytest.fixture
def oscillator(tmp_path):
    """CSV of v' = -4 q - 0.3 v + 2 F, from a closed-form solution, with its acceleration."""
    t = np.arange(0.0, 20.0, 0.01)
    force = 0.5 * np.cos(1.7 * t)
    roots = np.roots([1.0, 0.3, 4.0])
    gain = 1.0 / (1j * 1.7 - roots[0]) / (1j * 1.7 - roots[1])
    parts = [(1.0 - 0.5j, roots[0]), (gain, 1.7j)]
    q, v, a = (sum((c * r**k * np.exp(r * t)).real for c, r in parts) for k in range(3))
    return save(tmp_path / "oscillator.csv", t=t, q=q, v=v, F=force, acc=a)


@pytest.fixture
def drive_files(tmp_path):
    return save_drive(friction_drive(duration=6.0), tmp_path)


DECLARED = ("--equation", "q = v", "--equation", "v' = b*F - c*v", "--position", "q")


def coefficients(out, state, names):
    """Coefficients of a printed equation, by the names of its terms."""
    (line,) = (one.strip() for one in out.splitlines() if one.strip().startswith(f"{state}' ="))
    found = {}
    for part in line.split("=")[1].replace("- ", "+ -").split(" + "):
        number, _, term = part.strip().partition(" ")
        found[term] = float(number)
    assert set(found) == set(names)
    return [found[name] for name in names]


def test_fit_derives_velocity_and_acceleration_from_a_position(capsys, oscillator):
    code, out, err = run(capsys, "fit", oscillator, "--position", "q", "--inputs", "F")
    assert (code, err) == (0, "")
    assert "q' = q_dot\n" in out
    found = coefficients(out, "q_dot", ["q", "q_dot", "F"])
    np.testing.assert_allclose(found, [-4.0, -0.3, 2.0], rtol=2e-3)


def test_fit_takes_measured_states_and_derivatives_as_they_are(capsys, oscillator):
    targets = ("--states", "q,v", "--target", "q=v,v=acc")
    code, out, err = run(capsys, "fit", oscillator, *targets, "--inputs", "F")
    assert (code, err) == (0, "")
    np.testing.assert_allclose(coefficients(out, "v", ["q", "v", "F"]), [-4.0, -0.3, 2.0])


def test_fit_mixes_measured_and_computed_derivatives(capsys, oscillator):
    code, out, _ = run(
        capsys, "fit", oscillator, "--states", "q,v", "--target", "v=acc", "--inputs", "F"
    )
    assert code == 0
    np.testing.assert_allclose(
        coefficients(out, "v", ["q", "v", "F"]), [-4.0, -0.3, 2.0], rtol=1e-6
    )


def test_fit_judges_on_data_that_it_was_not_fitted_on(capsys, oscillator, tmp_path):
    t = np.arange(0.0, 5.0, 0.01)
    other = save(tmp_path / "other.csv", t=t, q=np.cos(t), v=-np.sin(t), F=0 * t, acc=-np.cos(t))
    options = ("--states", "q,v", "--target", "q=v,v=acc", "--inputs", "F")
    _, alone, _ = run(capsys, "fit", oscillator, *options)
    _, judged, _ = run(capsys, "fit", oscillator, "--test", other, *options)
    assert alone.split("Errors")[0] == judged.split("Errors")[0]
    error = float(judged.split("    v ")[-1].split()[0])
    assert error > 100.0


def test_fit_finds_the_friction_where_the_filter_smeared_its_switches(capsys, drive_files):
    train, test = drive_files[0], drive_files[1]
    code, out, _ = run(capsys, "fit", train, "--test", test, "--position", "q", "--inputs", "F")
    assert code == 0
    assert "sgn(q_dot)" in out
    errors = {line.split()[0]: line.split()[1:] for line in out.splitlines()[-2:]}
    assert float(errors["q"][1]) < 10.0
    assert "do not trust" not in out


@pytest.mark.filterwarnings("always:ElasticNet kept no term")
def test_fit_says_when_its_equations_predict_nothing(capsys, tmp_path):
    rng = np.random.default_rng(0)
    t = 0.01 * np.arange(600)
    path = tmp_path / "noise.csv"
    save(path, t=t, q=rng.standard_normal(600).cumsum())
    code, out, err = run(capsys, "fit", str(path), "--position", "q")
    assert code == 0
    assert "do not trust them" in out
    assert "ElasticNet kept no term for target 1" in err


def test_fit_prints_latex_and_code(capsys, oscillator):
    options = ("--states", "q,v", "--target", "q=v,v=acc", "--inputs", "F", "--latex")
    _, out, _ = run(capsys, "fit", oscillator, *options, "--code", "modelica")
    assert r"\dot{q} &= v \\" in out
    assert "der(v) = " in out


def test_the_same_seed_prints_the_same(capsys, oscillator):
    options = ("fit", oscillator, "--position", "q", "--inputs", "F", "--generations", "3")
    assert run(capsys, *options) == run(capsys, *options)


@pytest.mark.parametrize(("sign", "typed"), [(";", ";"), ("\t", "\\t")])
def test_columns_may_have_other_names_and_another_delimiter(capsys, tmp_path, sign, typed):
    t = np.arange(0.0, 6.0, 0.01)
    path = tmp_path / "decay.csv"
    np.savetxt(path, np.c_[t, np.exp(-t)], delimiter=sign, header=f"Time{sign}level", comments="")
    options = ("--time", "Time", "--states", "level", "--delimiter", typed, "--cutoff", "none")
    code, out, _ = run(capsys, "fit", str(path), *options)
    assert code == 0
    assert "level' = -level\n" in out


@pytest.mark.parametrize("position", ["q={q}", "q={q},v={v}"])
def test_columns_with_long_names_get_short_ones_for_the_equations(
    capsys, oscillator, tmp_path, position
):
    path = tmp_path / "long.csv"
    rows = Path(oscillator).read_text().removeprefix("t,q,v,F,acc")
    path.write_text("Time [s],Angle [rad],Rate (rad/s),Force / N,acc" + rows)
    sides = ("--equation", "q = v", "--equation", "v = -k*q - c*v + b*F", "--max-effects", "1")
    held = position.format(q="Angle [rad]", v="Rate (rad/s)")
    names = ("--time", "Time [s]", "--position", held, "--inputs", "F=Force / N")
    code, out, _ = run(capsys, "loop", str(path), *names, *sides)
    assert code == 0
    short = ("--position", position.format(q="q", v="v"), "--inputs", "F")
    assert out == run(capsys, "loop", oscillator, *short, *sides)[1]


def test_records_may_have_decimal_commas(capsys, tmp_path):
    t = np.arange(0.0, 6.0, 0.01)
    path = tmp_path / "decay.csv"
    rows = (f"{now:.6f};{level:.9f}".replace(".", ",") for now, level in np.c_[t, np.exp(-t)])
    path.write_text("\n".join(["t;level", *rows]))
    options = ("--states", "level", "--delimiter", ";", "--decimal", ",", "--cutoff", "none")
    code, out, _ = run(capsys, "fit", str(path), *options)
    assert code == 0
    assert "level' = -level\n" in out


@pytest.fixture
def turning(tmp_path):
    """Two CSVs of a wheel that a sine drives, its angle going on and starting again."""
    t = np.arange(0.0, 20.0, 0.01)
    angle = 300.0 * t + 40.0 * np.sin(1.3 * t)
    angles = {"on": angle, "again": np.mod(angle, 360.0)}
    force = np.sin(1.3 * t)
    return {key: save(tmp_path / f"{key}.csv", t=t, q=q, F=force) for key, q in angles.items()}


def test_an_unwrapped_angle_gives_what_one_that_goes_on_gives(capsys, turning):
    options = ("--position", "q", "--inputs", "F", "--generations", "2")
    wanted = run(capsys, "fit", turning["on"], *options)
    assert wanted[0] == 0
    # The force stays within a turn as well, and never starts again.
    turns = ("--unwrap", "q=360", "--unwrap", "F=6.2832")
    assert run(capsys, "fit", turning["again"], *options, *turns) == wanted
    short = ("--position", "phi=q", *options[2:])
    assert run(capsys, "fit", turning["again"], *short, "--unwrap", "phi=360")[0] == 0


def test_an_angle_that_starts_again_is_refused_until_its_turn_is_right(capsys, turning):
    options = ("fit", turning["again"], "--position", "q", "--inputs", "F")
    code, _, err = run(capsys, *options)
    assert code == 2
    assert "a whole turn" in err
    code, _, err = run(capsys, *options, "--unwrap", "q=6.2832")
    assert code == 2
    assert "must name an angle that stays within its turn; got 'q' from 0" in err


def test_empty_rows_at_the_ends_are_left_out(capsys, tmp_path):
    t = np.arange(0.0, 6.0, 0.01)
    rows = [f"{now:.6f},{level:.9f}" for now, level in np.c_[t, np.exp(-t)]]
    path = tmp_path / "decay.csv"
    path.write_text("\n".join(["t,level", "-0.01,", *rows, "6,", "6.01,"]))
    options = ("fit", str(path), "--states", "level", "--cutoff", "none")
    code, _, err = run(capsys, *options)
    assert code == 2
    assert "--drop-empty" in err
    code, out, _ = run(capsys, *options, "--drop-empty")
    assert code == 0
    assert "level' = -level\n" in out


def test_records_are_thinned_out_and_inputs_held_as_told(capsys, tmp_path):
    t = np.arange(0.0, 40.0, 0.1)
    power = np.sin(0.7 * t) + np.cos(0.31 * t)
    x = np.zeros(t.size)
    for k in range(t.size - 1):  # held from each sample to the next
        x[k + 1] = power[k] + (x[k] - power[k]) * np.exp(-0.1)
    path = tmp_path / "held.csv"
    np.savetxt(path, np.c_[t, x, power], delimiter=",", header="t,x,P", comments="")
    options = ("fit", str(path), "--states", "x", "--inputs", "P", "--operators", "add,mul")
    code, out, _ = run(capsys, *options, "--cutoff", "1", "--decimate", "2", "--held")
    assert code == 0
    rate, gain = (float(one) for one in re.findall(r"-?[0-9.]+", out.partition("x' = ")[2])[:2])
    assert (rate, gain) == pytest.approx((-1.0, 1.0), rel=2e-3)  # 5 % off where it is not held
    code, _, err = run(capsys, *options, "--cutoff", "1", "--decimate", "9")
    assert code == 2
    assert "must be at most 3 here" in err


@pytest.mark.parametrize("command", ["fit", "loop"])
def test_code_is_offered_in_every_language_of_to_code(command, capsys):
    with pytest.raises(SystemExit, match="0"):
        cli.main([command, "--help"])
    assert f"print code: {', '.join(LANGUAGES)}" in " ".join(capsys.readouterr().out.split())


@pytest.mark.slow
def test_loop_names_what_is_missing_and_saves_report_and_plot(capsys, drive_files, tmp_path):
    train, test = drive_files
    folder = tmp_path / "results"
    options = ("--inputs", "F", "--report", str(folder))
    code, out, err = run(capsys, "loop", train, "--test", test, *DECLARED, *options)
    assert (code, err) == (0, "")
    assert "Verdict: traced" in out
    assert "Coulomb friction" in out
    assert (folder / "report.txt").read_text(encoding="utf-8").strip() in out
    assert (folder / "residual.png").stat().st_size > 10_000
    assert str(folder / "residual.png") in out


@pytest.mark.slow
def test_loop_says_that_nothing_is_missing(capsys, tmp_path):
    train, test = save_drive(nothing_missing(duration=6.0), tmp_path)
    code, out, _ = run(capsys, "loop", train, "--test", test, *DECLARED, "--inputs", "F")
    assert code == 0
    assert "Verdict: complete" in out


def test_loop_names_the_free_parameters_before_it_searches(capsys, oscillator):
    sides = ("--equation", "q = v", "--equation", "v = Force - c*v", "--position", "q")
    code, out, err = run(capsys, "loop", oscillator, *sides, "--twins", "5")
    assert (code, out) == (2, "Free parameters: Force, c\n\n")
    assert "n_twins" in err


def test_loop_takes_known_constants(capsys, tmp_path):
    train, test = save_drive(nothing_missing(duration=6.0), tmp_path)
    sides = ("--equation", "q = v", "--equation", "v = F/m - c*v", "--known", "m=2")
    options = (*sides, "--position", "q", "--inputs", "F", "--max-effects", "0")
    _, out, _ = run(capsys, "loop", train, "--test", test, *options)
    assert "0.5 F" in out


def test_loop_without_position_reads_every_state(capsys, oscillator):
    sides = ("--equation", "q = v", "--equation", "v = -k*q - c*v + b*F")
    options = (*sides, "--inputs", "F", "--max-effects", "0")
    code, out, _ = run(capsys, "loop", oscillator, *options)
    assert code == 0
    found = coefficients(out, "v", ["q", "v", "F"])
    np.testing.assert_allclose(found, [-4.0, -0.3, 2.0], rtol=1e-2)


def test_without_matplotlib_the_report_is_saved_and_the_way_to_a_plot_told(
    capsys, drive_files, tmp_path, monkeypatch
):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    options = ("--inputs", "F", "--report", str(tmp_path), "--max-effects", "0")
    code, out, _ = run(capsys, "loop", *drive_files, *DECLARED, *options)
    assert code == 0
    assert 'pip install "pysindy-evolve[plots]"' in out
    assert (tmp_path / "report.txt").exists()


@pytest.mark.slow
def test_demo_finds_the_friction_and_says_where_it_saved_what(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, "demo")
    assert (code, err) == (0, "")
    folder = tmp_path / "pysindy-evolve-demo"
    for name in ("report.txt", "residual.png", "train.csv", "test.csv"):
        assert (folder / name).exists()
        assert name in out
    declared, corrected = out.split("Declared model, fitted")[1].split("Corrected model")
    assert "sgn(v)" not in declared
    assert "Coulomb friction" in corrected
    assert "sgn(v)" in corrected.split("Errors")[0]
    # The command that it shows gives the same report, here without terms that may grow.
    monkeypatch.setattr(commands, "close_loop", partial(close_loop, operators=()))
    command = out[out.rindex("pysindy-evolve loop") :].replace("\\\n", " ")
    code, again, _ = run(capsys, *shlex.split(command)[1:])
    assert code == 0
    names = [
        [line for line in text.splitlines() if " in the equation of " in line]
        for text in (out, again)
    ]
    assert names[0] == names[1] != []


WRONG = {
    "missing file": (["fit", "nowhere.csv", "--states", "q"], "nowhere.csv"),
    "folder": (["fit", ".", "--states", "q"], "must be one that can be opened"),
    "missing column": (["fit", "FILE", "--states", "q,w"], "got 'w', no such column"),
    "missing time": (["fit", "FILE", "--time", "T", "--states", "q"], "got 'T', no such column"),
    "no states": (["fit", "FILE"], "one of the arguments --states --position is required"),
    "name twice": (["fit", "FILE", "--states", "q,q"], "must be different names"),
    "order without position": (["fit", "FILE", "--states", "q", "--order", "2"], "--position"),
    "operator": (["fit", "FILE", "--states", "q", "--operators", "foo"], "got 'foo'"),
    "language": (["fit", "FILE", "--states", "q", "--code", "cobol"], "cobol"),
    "population": (["fit", "FILE", "--states", "q", "--population", "0"], "at least 1; got '0'"),
    "seed": (["fit", "FILE", "--states", "q", "--seed", "-1"], "seed"),
    "target": (["fit", "FILE", "--states", "q", "--target", "z=v"], "must name states; got 'z'"),
    "target twice": (["fit", "FILE", "--states", "q", "--target", "q=v,q=acc"], "once"),
    "turn of what": (["fit", "FILE", "--states", "q", "--unwrap", "w=360"], "Choose from q."),
    "no turn": (["fit", "FILE", "--states", "q", "--unwrap", "q"], 'write --unwrap "phi=360"'),
    "turn of zero": (["fit", "FILE", "--states", "q", "--unwrap", "q=0"], "turn above zero"),
    "turn in words": (["fit", "FILE", "--states", "q", "--unwrap", "q=2*pi"], "got 'q=2*pi'"),
    "turn twice": (
        ["fit", "FILE", "--states", "q", "--unwrap", "q=360", "--unwrap", "q=7"],
        "must be given once for each angle; got 'q' 2 times",
    ),
    "cutoff": (["fit", "FILE", "--states", "q", "--cutoff", "low"], "got 'low'"),
    "high cutoff": (["fit", "FILE", "--states", "q", "--cutoff", "900"], "got 900"),
    "not an equation": (["loop", "FILE", "--equation", "q"], "must be NAME=VALUE; got 'q'"),
    "code": (["loop", "FILE", "--equation", "q=__import__('os')"], "must be an expression"),
    "nonlinear": (["loop", "FILE", "--equation", "q=-q*k^2"], "linear in its free parameters"),
    "twice": (["loop", "FILE", "--equation", "q=-k*q", "--equation", "q=c"], "once for each state"),
    "no equation of a position": (
        ["loop", "FILE", "--equation", "v=-k*q", "--position", "q"], "Sort or add",
    ),
    "wrong position": (["loop", "FILE", "--equation", "q=-k*q", "--position", "v"], "Sort or add"),
    "not its derivative": (
        ["loop", "FILE", "--equation", "q=w", "--equation", "v=-k*q", "--position", "q"],
        "must be 'q = v', as v is derived from q; got another one",
    ),
    "known": (["loop", "FILE", "--equation", "q=-k*q", "--known", "k=a"], "numbers as values"),
    "twins": (["loop", "FILE", "--equation", "q=-k*q", "--twins", "3"], "at least 59"),
    "name of time": (["fit", "FILE", "--states", "t=q"], "t for time only; got 't' again"),
    "input and state": (["fit", "FILE", "--states", "q", "--inputs", "q"], "got 'q' again"),
    "report in a file": (["loop", "FILE", "--equation", "q=-k*q", "--report", "FILE"], "a folder"),
    "command": (["fix"], "'fix'"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_the_user_got_wrong_is_told_in_one_line_with_code_2(capsys, oscillator, case):
    arguments, told = WRONG[case]
    code, out, err = run(capsys, *(oscillator if one == "FILE" else one for one in arguments))
    assert (code, out) in [(2, ""), (2, "Free parameters: k\n\n")]
    assert err.startswith("pysindy-evolve")
    assert "error: " in err
    assert told in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("t,q,q\n0,1,1\n1,2,2\n", "2 columns of that name"),
        ("t,q\n0,1\n1,two\n", "got 'two' in column 'q', line 3"),
        ("t,q\n0,1\n1,\n", "got nothing in column 'q', line 3"),
        ("t,q\n0,1\n1,nan\n", "got 'nan' in column 'q', line 3"),
        ("t,q\n", "a header alone"),
        ("t,q\n0,1\n1,2\n", "must be at least 20 samples long"),
    ],
)
def test_a_bad_file_is_told_in_one_line_with_code_2(capsys, tmp_path, text, told):
    path = tmp_path / "bad.csv"
    path.write_text(text, encoding="utf-8")
    code, out, err = run(capsys, "fit", str(path), "--states", "q")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert told in err


def test_traceback_shows_where_an_error_came_from():
    with pytest.raises(FileNotFoundError, match=r"nowhere\.csv"):
        cli.main(["fit", "nowhere.csv", "--states", "q", "--traceback"])


def interrupted(given):
    raise KeyboardInterrupt


def test_an_interrupt_ends_with_130_and_a_message(capsys, monkeypatch):
    monkeypatch.setattr(cli, "demo", interrupted)
    code, _, err = run(capsys, "demo")
    assert code == 130
    assert "interrupted; nothing was found yet" in err


def test_an_interrupted_report_ends_with_130_and_a_message(capsys, monkeypatch):
    monkeypatch.setattr(cli, "demo", lambda given: False)
    code, _, err = run(capsys, "demo")
    assert code == 130
    assert "what is printed was found before that" in err


def test_an_interrupted_fit_prints_what_it_found_and_ends_with_130(capsys, monkeypatch, oscillator):
    from pysindy_evolve import library

    evolve = library.evolve

    def cut_short(*given, **settings):
        return replace(evolve(*given, **settings), interrupted=True)

    monkeypatch.setattr(library, "evolve", cut_short)
    code, out, err = run(capsys, "fit", oscillator, "--position", "q", "--generations", "5")
    assert (code, out.startswith("Equations")) == (130, True)
    assert "what is printed was found before that" in err


def test_a_warning_is_one_line_without_source(capsys, monkeypatch):
    import warnings

    def warn(given):
        warnings.resetwarnings()
        warnings.warn("look here", UserWarning, stacklevel=2)
        return True

    monkeypatch.setattr(cli, "demo", warn)
    assert run(capsys, "demo") == (0, "", "pysindy-evolve: warning: look here\n")


@pytest.mark.parametrize("command", ["demo", "fit", "loop"])
def test_help_names_every_flag_and_fits_the_screen(capsys, command):
    code, out, _ = run(capsys, command, "--help")
    assert code == 0
    assert "--seed" in out
    assert max(map(len, out.splitlines())) <= 100


def test_the_examples_of_the_help_are_commands_that_parse(capsys):
    import shlex

    from pysindy_evolve.cli import options, reproduction

    texts = [options.EXAMPLES, options.FIT_EXAMPLES, options.LOOP_EXAMPLES]
    text = "\n".join([*texts, reproduction.EXAMPLES])
    lines = text.replace("\\\n", " ").splitlines()
    shown = [line.strip() for line in lines if line.strip().startswith("pysindy-evolve ")]
    assert len(shown) == 14
    parser = options.make_parser(dict.fromkeys(("demo", "fit", "loop", "paper")))
    for line in shown:
        assert parser.parse_args(shlex.split(line)[1:]).command in line


def test_the_module_runs_as_a_program():
    done = subprocess.run(
        [sys.executable, "-m", "pysindy_evolve", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.startswith("pysindy-evolve ")


@pytest.mark.parametrize(
    ("option", "name"), [("--inputs", "Force"), ("--position", "x"), ("--time", "time")]
)
def test_a_misspelled_column_is_named_before_the_model_is_blamed(capsys, oscillator, option, name):
    columns = {"--inputs": "F", "--position": "q", "--time": "t"} | {option: name}
    pairs = [word for pair in columns.items() for word in pair]
    sides = ("--equation", "q = v", "--equation", "v = -k*q - c*v + b*F")
    code, _, err = run(capsys, "loop", oscillator, *pairs, *sides)
    assert code == 2
    assert f"{option} must name columns" in err
    assert f"got {name!r}" in err
    assert "'q', 'v', 'F', 'acc'" in err
