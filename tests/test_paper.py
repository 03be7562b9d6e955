"""Tables and figures of the paper: what is run, kept and printed, without running the searches."""

import csv
import json

import pytest

from pysindy_evolve import cli
from pysindy_evolve.paper import PARTS, Plan, facts, forget, plan, reproduce
from pysindy_evolve.paper.cases import Case
from pysindy_evolve.paper.store import Store
from pysindy_evolve.paper.tables import Table, accuracy
from pysindy_evolve.paper.trials import Trial, run

TABLES = ("table2", "figure10", "table4", "table5")


def trial(case, **changes):
    values = {
        "equation": "-994 q - 3.67 v - zdd - 2.18e6 q^3",
        "extra": (),
        "missing": (),
        "coefficient_error": 0.1,
        "error": 0.5 + case.seed,
        "measured_error": 3.0,
        "seconds": 1.25,
    }
    return Trial(case, **{**values, **changes})


@pytest.fixture
def searched(monkeypatch):
    """Cases that were run, by a search that takes no time; a case set as `stop` is interrupted."""

    class Searched(list):
        stop = None

    cases = Searched()

    def pretend(case):
        if case == cases.stop:
            raise KeyboardInterrupt
        cases.append(case)
        return trial(case)

    monkeypatch.setattr("pysindy_evolve.paper.results.run", pretend)
    return cases


@pytest.fixture
def small():
    return Plan(
        (0, 1), table2=(20.0, 19.0), figure10=(20.0, 5.0), table4=(30.0, 20.0), friction=(20.0,)
    )


def rows_of(path):
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def test_records_that_two_tables_share_are_run_once(small, searched, tmp_path):
    reproduce(tmp_path, small, TABLES)
    assert len(searched) == len(set(searched))
    numerical = [case.snr_db for case in searched if case.system == "numerical"]
    assert sorted(numerical) == [5.0] * 2 + [19.0] * 4 + [20.0] * 4


def test_a_second_start_runs_nothing_again(small, searched, tmp_path):
    first = reproduce(tmp_path, small, TABLES)
    searched.clear()
    assert reproduce(tmp_path, small, TABLES).tables == first.tables
    assert searched == []


def test_an_interrupt_keeps_what_is_finished_and_the_next_start_runs_the_rest(
    small, searched, tmp_path
):
    wanted = small.cases(TABLES)
    searched.stop = wanted[3]
    stopped = reproduce(tmp_path, small, TABLES)
    assert not stopped.finished
    assert searched == wanted[:3]
    assert stopped.tables[0].rows[0][6] == "2 of 2"  # what is there is in the table
    searched.clear()
    searched.stop = None
    assert reproduce(tmp_path, small, TABLES).finished
    assert searched == wanted[3:]


def test_half_a_line_of_a_killed_run_is_run_again(small, searched, tmp_path):
    reproduce(tmp_path, small, ("table2",))
    path = tmp_path / "trials.jsonl"
    whole = path.read_bytes()
    path.write_bytes(whole[:-20])
    searched.clear()
    reproduce(tmp_path, small, ("table2",))
    assert len(searched) == 1
    assert path.read_bytes() == whole


def test_more_runs_add_to_those_that_are_there(small, searched, tmp_path):
    reproduce(tmp_path, Plan((0,), figure10=(20.0,)), ("figure10",))
    reproduce(tmp_path, Plan((0, 1), figure10=(20.0,)), ("figure10",))
    assert [case.seed for case in searched] == [0, 1]


def test_forgotten_trials_are_run_again(small, searched, tmp_path):
    reproduce(tmp_path, small, ("table2",))
    forget(tmp_path)
    forget(tmp_path)  # nothing there is no error
    reproduce(tmp_path, small, ("table2",))
    assert len(searched) == 2 * len(small.for_table2())


def test_a_trial_is_the_same_after_it_was_written(tmp_path):
    one = trial(Case("rig", 30.0, 3, 2), extra=("sgn(q)",), missing=("v", "q^3"))
    Store(tmp_path / "new" / "trials.jsonl").add(one)
    assert Store(tmp_path / "new" / "trials.jsonl")[one.case] == one
    (line,) = (tmp_path / "new" / "trials.jsonl").read_text(encoding="utf-8").splitlines()
    assert json.loads(line)["case"]["experiment"] == 2


def test_table_2_has_the_row_of_the_paper_beside_ours(small, searched, tmp_path):
    reproduce(tmp_path, small, ("table2",))
    rows = rows_of(tmp_path / "table2.csv")
    assert [row["SNR dB"] for row in rows] == ["20", "19.5", "19", "18.5"]
    assert rows[0]["as measured: exact"] == rows[0]["exact"] == "2 of 2"
    assert rows[0]["paper"] == facts.TABLE_2[20.0].equation
    assert (rows[0]["error %"], rows[0]["mean error %"], rows[0]["largest"]) == (
        "0.7",
        "1.00",
        "1.50",
    )
    assert rows[1]["mean error %"] == "–"  # not in this plan


def test_table_4_has_one_row_an_experiment_and_one_a_noise(small, searched, tmp_path):
    reproduce(tmp_path, small, ("table4",))
    rows = rows_of(tmp_path / "table4.csv")
    assert [row["error %"] for row in rows] == ["3.9", "5.6", "4.7"]
    assert all(row["exact"] == "2 of 2" for row in rows)
    noises = [(row["noise on"], row["SNR dB"]) for row in rows_of(tmp_path / "table4_noise.csv")]
    sensors, alone = "both accelerometers", "acceleration alone"
    assert noises == [(sensors, "30"), (sensors, "20"), (alone, "20")]


def test_table_5_has_the_times_of_the_paper_and_ours(small, searched, tmp_path):
    reproduce(tmp_path, small, ("table5",))
    rows = rows_of(tmp_path / "table5.csv")
    assert rows[2]["method"] == "paper: ESparse"
    assert (rows[2]["exp. 1, s"], rows[-1]["exp. 1, s"]) == ("12.6", "1.2")


def test_figure_10_counts_extra_and_missing_terms_by_name(tmp_path):
    store = Store(tmp_path / "trials.jsonl")
    cases = [Case("numerical", 5.0, seed) for seed in range(3)]
    store.add(trial(cases[0], extra=("sgn(q)",)))
    store.add(trial(cases[1], extra=("sgn(q)", "q v"), missing=("q",)))
    store.add(trial(cases[2]))
    (table,) = reproduce(tmp_path, Plan((0, 1, 2), figure10=(5.0,)), ("figure10",)).tables
    (row,) = (dict(zip(table.header, row, strict=True)) for row in table.rows)
    assert row["here without any"] == row["exact"] == "1 of 3"
    assert row["accuracy %"] == "98.50"
    assert row["standard deviation"] == "1.00"
    assert row["which were extra or missing"] == "+sgn(q) (2), +q v (1), −q (1)"


def test_accuracy_of_one_run_has_no_spread():
    assert accuracy([trial(Case("numerical", 5.0, 0))]) == (99.5, 0.0)


def test_markdown_of_a_table_is_aligned_and_has_its_note():
    text = Table("a", "Title", ("x", "long"), (("longer", "1"),), "Note.").to_markdown()
    assert text.splitlines()[0] == "**Title**"
    assert len({len(line) for line in text.splitlines() if line.startswith("|")}) == 1
    assert text.endswith("Note.\n")


def test_results_of_other_packages_are_shown_with_table_5(small, searched, tmp_path):
    row = {"method": "A", "problem": "friction", "validation_error": 2.0, "coefficient_error": None}
    row |= {"exact": "no", "cpu": 3.0, "memory": 40.0, "lines": 9}
    rows = [row, {**row, "cpu": 5.0, "exact": "yes"}, {"method": "B", "problem": "friction"}]
    rows[2]["error"] = "not installed"
    path = tmp_path / "rows.jsonl"
    path.write_text("".join(f"{json.dumps(one)}\n" for one in rows), encoding="utf-8")
    tables = reproduce(tmp_path, small, ("table5",), peers_file=path).tables
    assert [table.name for table in tables] == ["table5", "table5_friction"]
    assert tables[1].rows[0] == ("A", "1 of 2", "–", "2.000", "4.00", "40", "9")
    assert tables[1].rows[1] == ("B", "failed", *["–"] * 5)
    assert "other packages" in (tmp_path / "report.md").read_text(encoding="utf-8")


def test_without_results_of_other_packages_table_5_stands_alone(small, searched, tmp_path):
    tables = reproduce(tmp_path, small, ("table5",), peers_file=tmp_path / "none").tables
    assert [table.name for table in tables] == ["table5"]


def test_quick_is_a_part_of_all():
    assert set(plan(quick=True).cases(PARTS)) <= set(plan().cases(PARTS))
    assert plan(1, quick=True).seeds == (0,)
    assert plan(3, first_seed=5).seeds == (5, 6, 7)


def test_settings_are_those_of_tables_1_and_3():
    assert Case("numerical", 20.0, 0).setting.options["population_size"] == 80
    options = Case("rig", 30.0, 0, 1).setting.options
    assert (options["population_size"], options["n_generations"]) == (150, 40)
    assert "div" in options["operators"]


def test_command_prints_the_tables_and_says_where_they_are(searched, capsys, tmp_path):
    folder = tmp_path / "out"
    code = cli.main(["paper", "--only", "table2", "--runs", "1", "--output", str(folder)])
    out = capsys.readouterr().out
    assert code == 0
    assert "Table 2." in out
    assert str(folder) in out


def test_command_says_how_to_go_on_after_an_interrupt(searched, capsys, tmp_path):
    searched.stop = Case("numerical", 19.5, 0, fused=True)
    options = ("paper", "--only", "table2", "--runs", "1", "--output", str(tmp_path))
    assert cli.main(list(options)) == 130
    assert "goes on from here" in capsys.readouterr().out
    assert searched == [Case("numerical", 20.0, 0, fused=True)]


def test_command_refuses_a_part_that_the_paper_does_not_have(capsys):
    with pytest.raises(SystemExit, match="2"):
        cli.main(["paper", "--only", "table9"])
    assert "must be some of table2" in capsys.readouterr().err


def test_fresh_forgets_what_was_finished(searched, capsys, tmp_path):
    options = ["paper", "--only", "table2", "--runs", "1", "--output", str(tmp_path)]
    cli.main(options)
    cli.main([*options, "--fresh"])
    assert len(searched) == 2 * 2 * len(facts.TABLE_2)


def test_figures_without_trials_of_their_own_are_drawn_from_the_record(tmp_path):
    pytest.importorskip("matplotlib")
    results = reproduce(tmp_path, plan(1), ("figure4", "figure5"))
    assert [path.name for path in results.figures] == ["figure4.png", "figure5.png"]
    assert all((tmp_path / f"{name}.pdf").exists() for name in ("figure4", "figure5"))


@pytest.mark.slow
def test_a_trial_knows_the_truth_and_fusing_helps():
    plain, fused = (run(Case("numerical", 20.0, 0, fused=fused)) for fused in (False, True))
    assert plain.exact
    assert fused.exact
    assert fused.error < 0.2 < plain.error < 2.0 < plain.measured_error
    assert fused.coefficient_error < 0.2


@pytest.mark.slow
def test_quick_command_makes_all_tables_and_figures(capsys, tmp_path):
    assert cli.main(["paper", "--quick", "--runs", "1", "--output", str(tmp_path)]) == 0
    assert "Table 5." in capsys.readouterr().out
    made = {path.stem for path in tmp_path.glob("*.png")} | {
        path.stem for path in tmp_path.glob("*.md")
    }
    assert set(PARTS) <= made
