"""Scenes of the repository changed at random: by values, names, structure, plugins and variants."""

import copy
import json
import random
import re

# Text that JSON has no value for, or that no two readers agree on.
RAW = ["NaN", "Infinity", "-Infinity", "1e400", "1" + 400 * "0", "0x10", "01", "+1", ".5", "'x'",
       "\"\\ud800\"", "{\"plugin\": \"gauss\", \"plugin\": \"exact\"}", 70 * "[" + 70 * "]"]
NUMBERS = [0, -1, 1, 2, 0.5, -0.0, 1e308, -1e308, 1e-308, 5e-324, 1e17, 2**31, 2**53 + 1, 2**63,
           2**64, -(2**63), 1e-9, 1e9, 3]
TEXTS = ["", "nan", "base", "gauss", "/", "../../x", "a\nb", "\u202e", "é", 300 * "x", "all", "left",
         "a1*", "1/0", "sqrt(-1)", "a1^a2^9", "*", "infinity"]
SIZES = [[2, 2], [3, 3], [1, 1], [0, 5], [5, 4], [-3, 9], [10**9, 10**9], [2, 9], [2.5, 3], [9, 6],
         [2**31, 2], [8]]
KINDS = {"surface": "surface", "energies": "energy", "forces": "force", "constraints": "constraint",
         "colliders": "collider", "integrator": "integrator", "solver": "solver",
         "outputs": "output", "probes": "probe", "shadow": "normal", "rest": "shape",
         "initial": "shape", "normal": "normal"}


class Raw(str):
    """Text that stands in a scene as it is."""


def without_comments(text):
    """JSON from a scene, whose comments begin with // outside of texts."""
    return re.sub(r'("(?:\\.|[^"\\])*")|//[^\n]*', lambda m: m.group(1) or "", text)


def dump(value):
    """JSON text of a value with raw parts."""
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)}: {dump(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(dump, value)) + "]"
    return json.dumps(value)


def small(scene):
    """The scene on few nodes, for three steps."""
    scene = copy.deepcopy(scene)
    scene.pop("$schema", None)
    scene["surface"]["nodes"] = [9, 9]
    for _, value in places(scene):  # of which loads still find some
        if isinstance(value, dict) and "centre" in value and "radius" in value:
            value["radius"] *= 4
    step = scene["integrator"].get("step") if isinstance(scene["integrator"], dict) else None
    scene["duration"] = 3 * (step or 0.01)
    return scene


def places(value, path=()):
    """All (path, value) below a value, itself first."""
    yield path, value
    items = value.items() if isinstance(value, dict) else \
        enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from places(item, path + (key,))


def parent_of(scene, path):
    for key in path[:-1]:
        scene = scene[key]
    return scene


def kind_at(path):
    """The kind of plugin that stands at a path, or None."""
    names = [key for key in path if isinstance(key, str)]
    return KINDS.get(names[-1]) if names else None


class Mutator:
    """Changes scenes; everything follows from the seed. `schemas`: of plugins, by (kind, name)."""

    def __init__(self, scenes, schemas, seed):
        self.scenes, self.schemas = scenes, schemas
        self.random = random.Random(seed)

    def mutant(self):
        """Text of a scene, and what was done to it."""
        name, scene = self.random.choice(sorted(self.scenes.items()))
        scene = small(scene)
        done = [name]
        for _ in range(self.random.choice([1, 1, 1, 2, 2, 3, 5])):
            done.append(self.change(scene))
        self.keep_short(scene)
        return self.text(scene), done

    def text(self, scene):
        text = dump(scene)
        if self.random.random() < 0.03:  # cut off, or a byte changed
            at = self.random.randrange(len(text))
            text = text[:at] + self.random.choice(["", "\x00", "}", ",", "\"", "\\"]) + \
                (text[at + 1:] if self.random.random() < 0.5 else "")
        return text

    def change(self, scene):
        if not scene:
            return "nothing"
        changes = [self.put_number, self.put_number, self.put_number, self.put_junk, self.delete,
                   self.rename, self.repeat, self.swap, self.graft, self.swap_plugin,
                   self.swap_plugin, self.swap_plugin, self.put_nodes, self.put_by_schema,
                   self.put_by_schema, self.add_variant]
        return self.random.choice(changes)(scene)

    def anywhere(self, scene, wanted=lambda value: True):
        found = [(path, value) for path, value in places(scene) if path and wanted(value)]
        return self.random.choice(found) if found else (None, None)

    def put(self, scene, path, value):
        parent_of(scene, path)[path[-1]] = value
        return f"{'/'.join(map(str, path))} = {dump(value)[:80]}"

    def put_number(self, scene):
        is_number = lambda value: isinstance(value, (int, float)) and not isinstance(value, bool)
        path, _ = self.anywhere(scene, is_number)
        return self.put(scene, path, self.random.choice(NUMBERS)) if path else "nothing"

    def junk(self):
        return self.random.choice([
            lambda: None, lambda: True, lambda: self.random.choice(NUMBERS),
            lambda: self.random.choice(TEXTS), lambda: [], lambda: {}, lambda: [[[]]],
            lambda: Raw(self.random.choice(RAW)), lambda: {"plugin": self.random.choice(TEXTS)},
            lambda: [self.random.choice(NUMBERS) for _ in range(self.random.randrange(5))]])()

    def put_junk(self, scene):
        path, _ = self.anywhere(scene)
        return self.put(scene, path, self.junk())

    def delete(self, scene):
        path, _ = self.anywhere(scene)
        del parent_of(scene, path)[path[-1]]
        return f"without {'/'.join(map(str, path))}"

    def rename(self, scene):
        path, value = self.anywhere(scene)
        parent, key = parent_of(scene, path), path[-1]
        if not isinstance(key, str) or not key:
            return "nothing"
        at = self.random.randrange(len(key))
        new = key[:at] + self.random.choice(["", "x", "/", "~", "\n", key[at] * 2]) + key[at + 1:]
        del parent[key]
        parent[new] = value
        return f"{'/'.join(map(str, path))} is called {new!r}"

    def repeat(self, scene):
        path, value = self.anywhere(scene, lambda value: isinstance(value, list))
        if path is None:
            return "nothing"
        items, times = list(value), self.random.choice([1, 1, 3, 40])
        value.extend(copy.deepcopy(item) for _ in range(times) for item in items)
        return f"{'/'.join(map(str, path))} has {len(value)} items"

    def swap(self, scene):
        (one, a), (two, b) = self.anywhere(scene), self.anywhere(scene)
        if one[:len(two)] == two or two[:len(one)] == one:
            return "nothing"
        self.put(scene, one, copy.deepcopy(b))
        self.put(scene, two, copy.deepcopy(a))
        return f"{'/'.join(map(str, one))} for {'/'.join(map(str, two))}"

    def graft(self, scene):
        other = small(self.scenes[self.random.choice(sorted(self.scenes))])
        key = self.random.choice(sorted(other))
        scene[key] = other[key]
        return f"{key} of another scene"

    def plugin(self, kind):
        names = sorted(name for of, name in self.schemas if of == kind)
        name = self.random.choice(names)
        use = self.by_schema(self.schemas[kind, name])
        use["plugin"] = name
        if kind == "integrator":
            use["step"] = self.random.choice([1e-4, 1e-3, 0.01, 0.01, 0.1, 1])
        return use

    def swap_plugin(self, scene):
        found = [path for path, value in places(scene)
                 if (kind_at(path) if path else None) and not isinstance(value, list)]
        if not found:
            return "nothing"
        path = self.random.choice(found)
        return self.put(scene, path, self.plugin(kind_at(path)))

    def by_schema(self, schema):
        """A value that a schema allows, often at the ends of what it does."""
        pick = self.random.choice
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return pick(schema["enum"])
        if "anyOf" in schema:
            return self.by_schema(pick(schema["anyOf"]))
        if "default" in schema and self.random.random() < 0.4:
            return copy.deepcopy(schema["default"])
        of = schema.get("type")
        if of in ("number", "integer"):
            low = schema.get("minimum", schema.get("exclusiveMinimum"))
            high = schema.get("maximum")
            value = pick([0.3, 1, 2, 7, 1e-3, 1e-12, 1e3, 1e12, low or 0, high or 1, 0.02, 0.1])
            value = max(value, low) if low is not None else pick([value, -value])
            value = min(value, high) if high is not None else value
            return int(min(max(value, -1e15), 1e15)) if of == "integer" else value
        if of == "boolean":
            return pick([True, False])
        if of == "array":
            least = schema.get("minItems", 0)
            count = self.random.randint(least, min(schema.get("maxItems", least + 3), least + 3))
            return [self.by_schema(schema.get("items", {})) for _ in range(count)]
        if of == "object":
            required = schema.get("required", [])
            return {key: self.by_schema(item) for key, item in schema.get("properties", {}).items()
                    if key in required or self.random.random() < 0.3}
        if of == "string":
            return pick(["a1", "left", "left_top", "x", "0.1*a2", "exact", "gauss", "flat", "steel"])
        return self.junk()

    def put_by_schema(self, scene):
        """One parameter of a plugin that is there, as its schema has it."""
        found = [(path, value) for path, value in places(scene)
                 if path and isinstance(value, dict)
                 and (kind_at(path), str(value.get("plugin"))) in self.schemas]
        if not found:
            return "nothing"
        path, value = self.random.choice(found)
        properties = self.schemas[kind_at(path), value["plugin"]]["properties"]
        key = self.random.choice(sorted(properties))
        return self.put(scene, path + (key,), self.by_schema(properties[key]))

    def put_nodes(self, scene):
        if not isinstance(scene.get("surface"), dict):
            return "nothing"
        return self.put(scene, ("surface", "nodes"), self.random.choice(SIZES))

    def add_variant(self, scene):
        path, _ = self.anywhere(scene)
        pointer = "/" + "/".join(map(str, path))
        pointer = self.random.choice([pointer, pointer, pointer + "/x", pointer[1:], "", "/-", "//",
                                      pointer + "/-", "/variants/v", "/energies/9/xi", "/~2"])
        variants = scene.setdefault("variants", {})
        if not isinstance(variants, dict):
            return "nothing"
        name = self.random.choice(["v", "v", "base", "", "..", "a/b", "w"])
        variants[name] = {pointer: self.junk()}
        return f"variant {name!r}: {pointer!r}"

    @staticmethod
    def keep_short(scene):
        """No more than a few steps, unless nobody can tell how many there are."""
        integrator, duration = scene.get("integrator"), scene.get("duration")
        step = integrator.get("step") if isinstance(integrator, dict) else None
        is_number = lambda value: isinstance(value, (int, float)) and not isinstance(value, bool)
        if is_number(step) and is_number(duration) and 0 < step < 1e300 and 8 * step < duration < 1e12:
            scene["duration"] = 4 * step
