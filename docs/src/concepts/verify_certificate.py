"""Verifies the certificates of strategies/snap without the analysis: python verify_certificate.py FILE

The script rebuilds every map and every inequality from the scenario, and takes only the functions P and the scales S
from the file. The scenario has a held slave that snaps back, no delay, position-force control and a rigid needle.
"""

import json
import sys

import numpy as np
import trocar


def held(system, tick):
    """Returns the step of x' = A x + B u over a tick with a held u."""
    n, inputs = system.B.shape
    whole = np.block([[system.A, system.B], [np.zeros((inputs, n + inputs))]]) * (tick / 2**12)
    step = np.eye(n + inputs) + whole + whole @ whole / 2 + whole @ whole @ whole / 6
    step = np.linalg.matrix_power(step, 2**12)
    return step[:n, :n], step[:n, n:]


class Loop:
    """The maps of a tick on (x, r, φ, w): the states of both machines, the held reference, the feedback force, and the
    force that is added to the tissue's K p + B v."""

    def __init__(self, scenario):
        event = scenario["augmentation"]
        assert scenario["controller.kind"] == "position-force" and scenario["channel.delay_s"] == 0
        assert event["force_law"] == "decay" and event["reengage"] == "snap" and event["freeze"] == "measured"
        assert event["decay_ratio"] == 0 and scenario["master.force_integral_gain"] > 0
        tick = self.tick = scenario.tick_s
        (a, b), (c, d) = (held(trocar.state_space(scenario, side), tick) for side in ("master", "slave"))
        n = self.needle = len(a)
        self.r = n + len(c)
        self.phi, self.w, self.size = self.r + 1, self.r + 2, self.r + 3
        loop = list(range(self.r))
        self.spaces = {"Loop": loop, "Fading": [*loop, self.phi], "Frozen": [*loop, self.r, self.phi]}
        self.spaces |= {"Driven" + name: [*at, self.w] for name, at in self.spaces.items()} | {"Input": [self.w]}
        self.free = np.eye(self.size)
        self.free[:n, :n], self.free[n : self.r, n : self.r] = a, c
        self.of_force, self.of_reference = np.zeros(self.size), np.zeros(self.size)
        self.of_force[:n], self.of_reference[n : self.r] = b[:, 2], d[:, 0]
        self.hand = scenario["scaling.position"] * self.row(0)
        self.scale = scenario["scaling.force"]
        self.decay = np.exp(-tick / event["decay_time_constant_s"])
        ticks = lambda key: round(event[key] / tick)
        longest = max(ticks("max_hold_s"), 1)
        self.held = (min(max(ticks("min_hold_s"), ticks("exit_quiet_s"), 1), longest), longest)
        self.blend, self.refractory = max(ticks("blend_s"), 1), max(ticks("refractory_s"), 1)

    def row(self, state):
        return np.eye(self.size)[state]

    def force(self, tissue):
        stiffness, damping = tissue
        motion = stiffness * self.row(self.needle) + damping * self.row(self.needle + 1)
        return self.scale * (motion + self.row(self.w))

    def step(self, reference, force, **stored):
        step = self.free + np.outer(self.of_reference, reference) + np.outer(self.of_force, force)
        for name, value in stored.items():
            step[getattr(self, name)] = value
        return step

    def teleoperation(self, tissue):
        return self.step(self.hand, self.force(tissue), r=self.hand, phi=self.force(tissue))

    def freeze(self):
        step = np.eye(self.size)
        step[self.r] = self.row(self.needle)
        return step

    def frozen(self):
        force = self.decay * self.row(self.phi)
        return self.step(self.row(self.r), force, phi=force)

    def cross_fade(self, tissue, weight):
        return self.step(self.hand, weight * self.force(tissue) + (1 - weight) * self.row(self.phi))

    def map(self, to, start, step=None):
        return (np.eye(self.size) if step is None else step)[np.ix_(self.spaces[to], self.spaces[start])]


def pieces(ticks, most):
    """Returns the lengths of the pieces of a function in time."""
    count = min(most, ticks)
    return [(k + 1) * ticks // count - k * ticks // count for k in range(count)]


def inequalities(loop, file, choice, driven):
    """Yields the functions with their spaces, and then each inequality: name, space of its rows, powers and terms.

    A term has a factor, the index of a function, and maps: each a matrix, its source, its target, and true for a power.
    """
    soft, stiff, least, most = *file["stiffness_n_per_m"], *file["damping_n_s_per_m"]
    tissues = [(soft, least), (stiff, least)]
    for tissue in [(soft, most), (stiff, most), (0.0, 0.0)] if driven else []:
        tissues += [] if tissue in tissues else [tissue]
    fade, dwell = (pieces(ticks, choice["pieces"]) for ticks in (loop.blend, choice["dwell_ticks"] - 1))
    functions = [(f"cross_fade_{k}", "Fading") for k in range(len(fade) + 1)]
    functions += [(f"teleoperation_{k}", "Loop") for k in range(len(dwell) + 1)]
    begin, last, force = len(fade) + 1, len(functions) - 1, len(functions)
    functions += [("additional_force_0", "Input"), ("bound_0", "Number")] if driven else []
    yield functions
    decay = np.exp(-loop.tick * choice["rate_per_s"])
    entry_factor = choice["contraction"] / decay ** (choice["dwell_ticks"] - 1)
    assert 0 < decay <= 1 and 0 < choice["contraction"] <= 1 and (entry_factor <= 1 or not driven)
    rows = lambda space: "Driven" + space if driven else space
    one = lambda to, start: (loop.map(to, start), start, to, False)
    drive = lambda factor, start: [(factor, force, [one("Input", start)])] if driven else []

    def decaying(name, start, nodes, ticks, step, factor):
        space = start.removeprefix("Driven")
        for tick in sorted({0, ticks - 1}):
            terms = []
            for done, sign, to in ((tick, factor, one(space, start)), (tick + 1, -1, (step, start, space, False))):
                shares = ((ticks - done, nodes[0]), (done, nodes[1]))
                terms += [(part / ticks * sign, node, [to]) for part, node in shares if part]
            yield name, start, None, terms + drive(1 - factor, start)

    for index, (_, space) in enumerate(functions[: force + driven]):
        yield "positive", space, None, [(1, index, [one(space, space)])]
    start = rows("Loop")
    level = [(entry_factor, last, [one("Loop", start)]), *drive(1 - entry_factor, start)]
    frozen = (loop.map("Frozen", "Frozen", loop.frozen()), "Frozen", "Frozen", True)
    steps = [loop.map("Frozen", start, loop.freeze() @ loop.teleoperation(tissue)) for tissue in tissues]
    entries = [(step, start, "Frozen", False) for step in steps]
    for entry in entries:
        yield "entering", start, loop.held, [*level, (-1, 0, [one("Fading", "Frozen"), frozen, entry])]
    weight = lambda tick: (tick / loop.blend) ** 2 * (3 - 2 * tick / loop.blend)
    for piece, (first, ticks) in enumerate(zip(np.cumsum([0, *fade]), fade)):
        for tissue in tissues:
            for end in sorted({1, ticks}):
                step = loop.map("Fading", rows("Fading"), loop.cross_fade(tissue, weight(first + end)))
                nodes = (piece, piece + 1)
                yield from decaying("cross-fade", rows("Fading"), nodes, ticks, step, decay if driven else 1.0)
    yield "faded", "Fading", None, [(1, begin - 1, [one("Fading", "Fading")]), (-1, begin, [one("Loop", "Fading")])]
    for tissue in tissues:
        step = loop.map("Loop", start, loop.teleoperation(tissue))
        for nodes, ticks in [((last, last), 1), *(((begin + k, begin + k + 1), n) for k, n in enumerate(dwell))]:
            yield from decaying("dwelling", start, nodes, ticks, step, decay)
    if driven:
        number = (np.eye(1), "Number", "Number", False)
        yield "positive", "Number", None, [(1, force + 1, [number])]
        quantities = [loop.row(state) / bound for state, bound in zip((loop.needle, 0), choice["bounds_m_per_n"])]
        of = lambda space: [(row[None, loop.spaces[space]], space, "Number", False) for row in quantities]
        for index, (_, space) in enumerate(functions[:force]):
            for quantity in of(space):
                yield "bounded", space, None, [(1, index, [one(space, space)]), (-1, force + 1, [quantity])]
        for entry in entries:
            for quantity in of("Frozen"):
                yield "bounded", start, (0, loop.held[1]), [*level, (-1, force + 1, [quantity, frozen, entry])]
        level = (np.eye(1), "Input", "Number", False)
        yield "force", "Input", None, [(1, force + 1, [level]), (-1, force, [one("Input", "Input")])]


def check_same(written, required, maps):
    """Checks that an inequality of the file is the required one."""
    name, rows, powers, terms = required
    assert (written["name"], written["rows"], written["powers"]) == (name, rows, powers and list(powers)), name
    assert len(written["terms"]) == len(terms), name
    for term, (factor, function, chain) in zip(written["terms"], terms):
        assert term["function"] == function and np.isclose(term["factor"], factor, rtol=1e-9), name
        assert [one["is_power"] for one in term["maps"]] == [is_power for *_, is_power in chain], name
        for one, (matrix, *_) in zip(term["maps"], chain):
            assert np.allclose(maps[one["map"]]["matrix"], matrix, rtol=1e-7, atol=1e-12), name


def eigenvalues(inequality, p, scale):
    """Yields the smallest eigenvalue of an inequality, relative to the largest, for each power."""
    name, rows, powers, terms = inequality
    scaled = lambda m, start, to, is_power: (np.linalg.solve(scale[to], m @ scale[start]), is_power)
    chains = [[scaled(*one) for one in chain] for *_, chain in terms]
    first, last = powers or (0, 0)
    now = [[np.linalg.matrix_power(m, first) if is_power else m for m, is_power in chain] for chain in chains]
    for _ in range(first, last + 1):
        maps = [np.linalg.multi_dot([*chain, np.eye(len(scale[rows]))]) for chain in now]
        total = sum(factor * m.T @ p[function] @ m for (factor, function, _), m in zip(terms, maps))
        assert np.all(np.diag(total) > 0), name
        # Rows of similar size: this does not change the sign of an eigenvalue.
        root = np.sqrt(np.diag(total))
        values = np.linalg.eigvalsh((total + total.T) / 2 / np.outer(root, root))
        assert values[0] > 0, (name, values[0])
        yield values[0] / values[-1]
        now = [[m @ n if is_power else m for m, (n, is_power) in zip(*both)] for both in zip(now, chains)]


def check(name, certificate, file, loop):
    """Returns the number of conditions and the smallest eigenvalue, relative to the largest."""
    choice, driven = certificate["choice"], name == "statement"
    assert choice["is_driven"] == driven and (name == "shortest_dwell" or choice["dwell_ticks"] <= loop.refractory)
    functions, *required = inequalities(loop, file, choice, driven)
    assert [(one["name"], one["space"]) for one in certificate["functions"]] == functions, "other functions"
    assert len(certificate["inequalities"]) == len(required), "an inequality is missing"
    p = [np.array(function["p"]) for function in certificate["functions"]]
    assert all(np.array_equal(matrix, matrix.T) for matrix in p), "not symmetric"
    scale = {name: np.array(space["scale"]) for name, space in certificate["spaces"].items()}
    smallest = []
    for written, inequality in zip(certificate["inequalities"], required):
        check_same(written, inequality, certificate["maps"])
        smallest += eigenvalues(inequality, p, scale)
    return len(smallest), min(smallest)


def verify(file, scenario="strategies/snap"):
    """Returns the number of conditions and the smallest relative eigenvalue of each certificate of a file."""
    scenario = trocar.Scenario.load(scenario)
    margins = trocar.margins(scenario)
    (softest, stiffest), (smallest, largest) = margins.tissue_n_per_m, margins.tissue_n_s_per_m
    (low, high), (least, most) = file["stiffness_n_per_m"], file["damping_n_s_per_m"]
    assert low <= softest and stiffest <= high and least <= smallest and largest <= most, "another tissue"
    assert file["tick_s"] == scenario.tick_s and file["delay_ticks"] == 0, "another tick or delay"
    loop = Loop(scenario)
    return {name: check(name, certificate, file, loop) for name, certificate in file["certificates"].items()}


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        for name, (count, worst) in verify(json.load(file)).items():
            print(f"{name}: {count} conditions hold, smallest relative eigenvalue {worst:.1e}")
