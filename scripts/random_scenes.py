"""Scenes made at random, to see whether implicit steps always find their solution."""

import math

STEPS = 20


def log_uniform(random, low, high):
    return math.exp(random.uniform(math.log(low), math.log(high)))


def vector(random, size):
    return [random.uniform(-size, size) for _ in range(3)]


def shape(random, size):
    """A shape whose radius fits the size, or none (flat)."""
    radius = max(size) * log_uniform(random, 0.5, 5)
    return random.choice([
        None, None,
        {"plugin": "arc", "radius": radius, "along": random.choice([1, 2]),
         "side": random.choice([-1, 1])},
        {"plugin": "sphere_patch", "radius": radius},
        {"plugin": "wave", "amplitude": 0.05 * max(size), "wavelength": 0.7 * max(size)},
    ])


def energies(random, size):
    """Stiffness over eight decades; thin and thick."""
    thickness = max(size) * log_uniform(random, 3e-4, 3e-2)
    young = log_uniform(random, 1e2, 1e10)
    if random.random() < 0.6:
        return [{"plugin": "koiter", "young": young, "thickness": thickness,
                 "poisson": random.uniform(0, 0.45)}]
    eta = young * thickness
    return [{"plugin": "stretching", "eta": eta},
            {"plugin": "bending_variational", "xi": eta * thickness ** 2 / 12}]


def forces(random, size, weight):
    """Loads as large as a few times the weight [N]."""
    where = {"centre": [size[0] * random.random(), size[1] * random.random()],
             "radius": 0.3 * max(size)}
    area = size[0] * size[1]
    share = log_uniform(random, 0.1, 10)
    choices = [
        {"plugin": "gravity", "acceleration": vector(random, 10)},
        {"plugin": "point_load", "force": vector(random, share * weight), "where": where},
        {"plugin": "edge_load", "where": {"boundary": random.choice(["left", "right", "top"])},
         "force": vector(random, share * weight / max(size))},
        {"plugin": "pressure", "pressure": random.uniform(-1, 1) * share * weight / area},
        {"plugin": "wind", "velocity": vector(random, 10)},
        {"plugin": "viscous_fluid", "viscosity": log_uniform(random, 1e-2, 10),
         "velocity": vector(random, 3)},
        {"plugin": "spring", "anchor": vector(random, max(size)), "where": where,
         "stiffness": share * weight / max(size)},
    ]
    return random.sample(choices, random.randint(1, 3))


def constraints(random):
    side = random.choice(["left", "right", "bottom", "top"])
    return random.choice([
        [],
        [{"plugin": "pin", "where": {"corners": "all"}}],
        [{"plugin": "pin", "where": {"corners": ["left_bottom", "left_top"]}}],
        [{"plugin": "pin", "where": {"boundary": side}}],
        [{"plugin": "clamp", "where": {"boundary": "left"}}],
        [{"plugin": "move", "where": {"boundary": "left"}, "times": [0, 1],
          "displacements": [[0, 0, 0], vector(random, 0.3)]}],
    ])


def random_scene(random, integrator="backward_euler"):
    """One scene: sizes, stiffness, rest shapes, loads, supports, steps; `random` decides."""
    length = log_uniform(random, 0.1, 10)
    size = [length, length * log_uniform(random, 0.2, 1)]
    density = log_uniform(random, 0.02, 20)
    step = log_uniform(random, 1e-3, 0.3)
    surface = {"plugin": "grid", "nodes": [random.randint(5, 25), random.randint(5, 25)],
               "size": size}
    rest = shape(random, size)
    if rest:
        surface["rest"] = rest
    scene = {
        "surface": surface,
        "material": {"density": density,
                     "damping": random.choice([0, density * log_uniform(random, 0.1, 10)]),
                     "rayleigh_stiffness": random.choice([0, 0, step])},
        "energies": energies(random, size),
        "forces": forces(random, size, 10 * density * size[0] * size[1]),
        "constraints": constraints(random),
        "integrator": {"plugin": integrator, "step": step},
        "duration": STEPS * step,
        "limits": {"distance": 1e9},
        "frames": {"write": False},
        "probes": ["newton", "time_step"],
    }
    # Clamps lie along an axis; shapes that bend away from it are pinned instead.
    if rest and scene["constraints"] and scene["constraints"][0]["plugin"] == "clamp":
        scene["constraints"][0]["plugin"] = "pin"
    if random.random() < 0.2:
        scene["colliders"] = [{"plugin": "sphere", "centre": [0.5 * size[0], 0.5 * size[1],
                                                              -3 * length],
                               "radius": length}]
    return scene


def bodies(random, size, drop):
    """A floor, and one to three bodies between it and the surface."""
    length = max(size)
    floor = {"plugin": "plane", "point": [0, 0, -3 * length]}
    choices = []
    for _ in range(random.randint(1, 3)):
        radius = length * log_uniform(random, 0.1, 0.6)
        centre = [size[0] * random.random(), size[1] * random.random(), -drop - radius]
        choices.append(random.choice([
            {"plugin": "sphere", "centre": centre, "radius": radius},
            {"plugin": "box", "centre": centre, "size": [radius, radius, 2 * radius],
             "rounding": 0.2 * radius},
            {"plugin": "cylinder", "centre": centre, "axis": [1, random.random(), 0],
             "radius": radius, "height": 4 * radius, "rounding": 0.1 * radius},
        ]))
    for body in [floor, *choices]:
        body["friction"] = random.choice([0, random.uniform(0.05, 1)])
    return [floor, *choices]


def random_contact_scene(random, integrator="backward_euler"):
    """Cloth to sheet metal that falls, is blown or thrown on bodies, mostly held by nothing."""
    length = log_uniform(random, 0.1, 3)
    size = [length, length * log_uniform(random, 0.3, 1)]
    density = log_uniform(random, 0.05, 5)
    drop = 0.05 * length
    step = random.choice([0.2, 0.5, 1]) * 0.1 * math.sqrt(length / 10)
    thickness = length * log_uniform(random, 3e-4, 1e-2)
    loads = [{"plugin": "gravity"}]
    if random.random() < 0.5:
        loads.append({"plugin": "wind", "velocity": vector(random, 3)})
    if random.random() < 0.3:
        loads.append({"plugin": "viscous_fluid", "viscosity": log_uniform(random, 1e-2, 1),
                      "velocity": vector(random, 1)})
    return {
        "surface": {"plugin": "grid", "nodes": [random.randint(9, 25), random.randint(9, 25)],
                    "size": size},
        "material": {"density": density,
                     "damping": random.choice([0, density * log_uniform(random, 0.1, 10)])},
        "energies": [{"plugin": "koiter", "young": density / thickness * length
                      * log_uniform(random, 1e3, 1e6), "thickness": thickness,
                      "poisson": random.uniform(0, 0.45)}],
        "forces": loads,
        "constraints": random.choice([[], [], [
            {"plugin": "pin", "where": {"corners": "left_bottom"}}]]),
        "colliders": bodies(random, size, drop),
        "velocity": random.choice([[0, 0, 0], vector(random, 3 * math.sqrt(length))]),
        "integrator": {"plugin": integrator, "step": step},
        "duration": 2 * STEPS * step,
        "limits": {"distance": 1e9},
        "frames": {"write": False},
        "probes": ["newton", "time_step", "contact"],
    }
