"""Verifies certificate.json again: python verify_certificate.py FILE"""

import json
import sys

import numpy as np


def verify(certificate):
    """Returns the number of conditions and the smallest eigenvalue, relative to the largest."""
    spaces = certificate["spaces"]
    scale = {name: np.array(space["scale"]) for name, space in spaces.items()}
    for name, space in spaces.items():
        assert len(space["states"]) == len(scale[name]), name

    functions = []
    for function in certificate["functions"]:
        p = np.array(function["p"])
        assert np.array_equal(p, p.T), function["name"]
        functions.append(p)

    # Maps between scaled states: states are scale @ scaled states.
    maps = []
    for entry in certificate["maps"]:
        start, end = scale[entry["from"]], scale[entry["to"]]
        maps.append(np.linalg.solve(end, np.array(entry["matrix"]) @ start))

    count, worst = 0, np.inf
    for inequality in certificate["inequalities"]:
        size = len(scale[inequality["rows"]])
        first, last = inequality["powers"] or (0, 0)
        powers = {}
        for power in range(first, last + 1):
            total = np.zeros((size, size))
            for term in inequality["terms"]:
                chain = np.eye(size)
                for factor in reversed(term["maps"]):
                    step = maps[factor["map"]]
                    if factor["is_power"]:
                        key = factor["map"]
                        if key in powers:
                            powers[key] = step @ powers[key]
                        else:
                            powers[key] = np.linalg.matrix_power(step, power)
                        step = powers[key]
                    chain = step @ chain
                total += term["factor"] * chain.T @ functions[term["function"]] @ chain
            # Rows of similar size: this does not change the sign of an eigenvalue.
            root = np.sqrt(np.abs(np.diag(total)))
            assert np.all(np.diag(total) > 0), (inequality["name"], power)
            values = np.linalg.eigvalsh((total + total.T) / 2 / np.outer(root, root))
            assert values[0] > 0, (inequality["name"], power, values[0])
            worst = min(worst, values[0] / values[-1])
            count += 1
    return count, worst


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        content = json.load(file)
    for name, certificate in content["certificates"].items():
        count, worst = verify(certificate)
        print(f"{name}: {count} conditions hold, smallest relative eigenvalue {worst:.1e}")
