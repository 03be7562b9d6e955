"""DEAP: genetic programming as in its own example of symbolic regression."""

from __future__ import annotations

import operator
import random

import numpy as np
from deap import algorithms, base, creator, gp, tools
from run import Data, Found


def genetic_programming(data: Data, seed: int) -> Found:
    """Population 250, 80 generations, + - * abs and sgn (the operators of the paper's table 1),
    numbers from -5 to 5; one-point crossover 0.9, uniform mutation 0.1, tournament of 3, ramped
    half and half from 2 to 6, trees up to height 17; variables of unit RMS and a target of unit
    size; mean square error on all rows."""
    random.seed(seed)
    size, scale = np.sqrt(np.mean(data.columns**2, axis=0)), np.std(data.a)
    columns, y = list((data.columns / size).T.copy()), data.a / scale

    pset = gp.PrimitiveSet("acceleration", 3)
    for function, arity in ((np.add, 2), (np.subtract, 2), (np.multiply, 2)):
        pset.addPrimitive(function, arity)
    pset.addPrimitive(np.abs, 1, name="abs")
    pset.addPrimitive(np.sign, 1, name="sgn")
    pset.addEphemeralConstant("number", lambda: random.uniform(-5.0, 5.0))
    pset.renameArguments(**{f"ARG{i}": name for i, name in enumerate(data.names)})
    creator.create("Fitness", base.Fitness, weights=(-1.0,))
    creator.create("Individual", gp.PrimitiveTree, fitness=creator.Fitness)

    def error(individual: gp.PrimitiveTree) -> tuple[float]:
        with np.errstate(all="ignore"):
            mse = np.mean((gp.compile(individual, pset)(*columns) - y) ** 2)
        return (float(mse) if np.isfinite(mse) else np.inf,)

    toolbox = base.Toolbox()
    toolbox.register("expr", gp.genHalfAndHalf, pset=pset, min_=2, max_=6)
    toolbox.register("individual", tools.initIterate, creator.Individual, toolbox.expr)
    toolbox.register("population", tools.initRepeat, list, toolbox.individual)
    toolbox.register("evaluate", error)
    toolbox.register("select", tools.selTournament, tournsize=3)
    toolbox.register("mate", gp.cxOnePoint)
    toolbox.register("expr_mut", gp.genFull, min_=0, max_=2)
    toolbox.register("mutate", gp.mutUniform, expr=toolbox.expr_mut, pset=pset)
    for name in ("mate", "mutate"):
        toolbox.decorate(name, gp.staticLimit(operator.attrgetter("height"), max_value=17))
    best = tools.HallOfFame(1)
    algorithms.eaSimple(toolbox.population(250), toolbox, 0.9, 0.1, 80, halloffame=best, verbose=0)

    def predict(z: np.ndarray) -> np.ndarray:
        return scale * gp.compile(best[0], pset)(*(z / size).T)

    return Found(str(best[0]), predict)


METHODS = {"DEAP genetic programming, 250 x 80": genetic_programming}
