"""Scenes that are wrong, one way each, and what must be said of them; and some that are right.

Python: `CASES` and `GOOD`. From elsewhere: `cases.py FOLDER` writes each scene to
FOLDER/NAME/scene.json with the files that it names, and FOLDER/index.json with what is expected.
"""

import copy
import dataclasses
import json
import sys
from pathlib import Path

# What no JSON Schema can say: why, and what the reader says. Every bad scene that the schema accepts
# names its class.
BEYOND_SCHEMA = {
    "syntax": ("the text is not JSON: there is nothing that a schema could look at", ""),
    "reader": ("JSON parsers differ on it, or are silent", ""),
    "nodes": ("which nodes there are is for the surface to say",
              r"selects no node|has no (node|boundary|corner) "),
    "memory": ("how many nodes fit depends on the machine", r"can be numbered|this machine has"),
    "files": ("a schema sees no other files",
              r"no such file|is a folder|not a regular file|cannot be read|: has \d+ positions"
              r"|has more than|is not a finite number|: has \d+ numbers|is longer than"),
    "pointers": ("what a variant's pointer leads to, and what is right there", r"variant \""),
    "relations": ("values that do not fit each other",
                  r"at least one step|more than 1e\+15 steps|they must be as many"
                  r"|takes a normal estimator|of all together|symmetric differences|keep one of them"),
    "order": ("numbers that must ascend, or be equal",
              r"ascending times|must ascend|a1 <= b1|12 must equal 21"),
    "shapes": ("whether a shape closes, or goes around more than once",
               r"does not close|more than once around|a sphere of radius|must be thinner"),
    "formulas": ("what a text means", r"expected a formula|a position must be finite|is \S+ at a1 = "),
    "spelling": ("whole numbers beyond 2^53, written as floating-point numbers",
                 r"found \S*1e\+300\S*, expected .*whole number"),
    "plugin": ("what a plugin's constructor alone knows",
               r"is empty|must be 1 or -1|too extreme|normal is 0|rounding is more"
               r"|inside of this collider|without contact|no number holds|no area around node|weighs"
               r"|number of waves|is 0, expected more than 0|give it, or a 'material'"),
}

BASE = {
    "surface": {"plugin": "grid", "nodes": [9, 9], "size": [1.0, 1.0], "differences": "forward",
                "border": "paper", "weights": "equal"},
    "material": {"density": 0.1, "damping": 1.0},
    "energies": [
        {"plugin": "stretching", "eta": 0.01},
        {"plugin": "bending", "xi": 1e-6, "form": "expanded",
         "normal": {"plugin": "gauss", "delta": 0.5}},
    ],
    "forces": [{"plugin": "point_load", "force": [0, 0, -0.01],
                "where": {"centre": [0.5, 0.5], "radius": 0.13}}],
    "constraints": [{"plugin": "pin", "where": {"boundary": "all"}}],
    "integrator": {"plugin": "semi_implicit", "step": 0.02},
    "duration": 0.2,
    "outputs": [{"plugin": "vtk", "every": 5}],
    "probes": ["energy", "lowest"],
}

REMOVE = object()


def changed(changes):
    """The base with the values at some JSON pointers replaced, added ("-" at a list) or removed."""
    scene = copy.deepcopy(BASE)
    for pointer, value in changes.items():
        *path, last = [step.replace("~1", "/").replace("~0", "~") for step in pointer.split("/")[1:]]
        at = scene
        for step in path:
            at = at[int(step)] if isinstance(at, list) else at[step]
        if isinstance(at, list) and last == "-":
            at.append(value)
        elif value is REMOVE:
            del at[int(last) if isinstance(at, list) else last]
        else:
            at[int(last) if isinstance(at, list) else last] = value
    return scene


def text_of(changes):
    return json.dumps(changed(changes), indent=1, ensure_ascii=False)


@dataclasses.dataclass
class Case:
    name: str
    text: bytes  # of scene.json
    place: str = ""  # "at /POINTER", or ":LINE:COLUMN"
    rule: str = ""  # a part of what is said
    near: str = ""  # the nearest valid name
    beyond: str = ""  # a class of BEYOND_SCHEMA; empty: the schema rejects the scene
    files: dict = dataclasses.field(default_factory=dict)  # beside the scene; None: a folder
    runs: bool = False  # the base is right: `deform run` has no reason to look at the variant's parts


CASES = []


def bad(name, changes, place, rule, near="", beyond="", files=None):
    CASES.append(Case(name, text_of(changes).encode(), place, rule, near, beyond, files or {}))


def raw(name, text, place, rule, near="", beyond="syntax"):
    data = text if isinstance(text, bytes) else text.encode()
    CASES.append(Case(name, data, place, rule, near, beyond))


def shape_file(rows):
    return "".join(f"{i * 0.125} {j * 0.125} 0\n" for j in range(9) for i in range(9)
                   if i + 9 * j < rows)


# ---- keys ---------------------------------------------------------------------------------------
bad("key_misspelt", {"/materal": {}}, "at /materal", 'a scene has no "materal"', "material")
bad("key_upper_case", {"/Duration": 1}, "at /Duration", "a scene has no", "duration")
bad("key_of_nothing", {"/zzzzzzzzzz": 1}, "at /zzzzzzzzzz", "a scene has no")
bad("key_empty", {"/": 1}, "at /", 'a scene has no ""')
bad("key_with_slash", {"/a~1b": 1}, "at /a~1b", 'a scene has no "a/b"')
bad("key_in_material", {"/material/densty": 1}, "at /material/densty", "material has no", "density")
bad("key_in_surface", {"/surface/node": [9, 9]}, "at /surface/node", 'no "node"', "nodes")
bad("key_in_energy", {"/energies/0/etta": 1}, "at /energies/0/etta", 'stretching" has no', "eta")
bad("key_in_normal", {"/energies/1/normal/delt": 1}, "at /energies/1/normal/delt", "has no", "delta")
bad("key_in_selector", {"/forces/0/where/radus": 1}, "at /forces/0/where/radus",
    "this selector has no", "radius")
bad("key_of_another_plugin", {"/constraints/0/times": [0]}, "at /constraints/0/times", "has no")
bad("key_in_integrator", {"/integrator/dt": 0.1}, "at /integrator/dt", "has no")
bad("key_in_output", {"/outputs/0/evry": 2}, "at /outputs/0/evry", "has no", "every")
bad("key_in_limits", {"/limits": {"distanc": 2}}, "at /limits/distanc", "has no", "distance")
bad("collider_unknown", {"/colliders": ["plain"]}, "at /colliders/0", "there is no collider plugin",
    "plane")
bad("collider_friction", {"/colliders": [{"plugin": "plane", "point": [0, 0, -1], "friction": -1}]},
    "at /colliders/0/friction", "found -1, expected number >= 0")
bad("collider_of_another_kind", {"/colliders": ["gravity"]}, "at /colliders/0", '"gravity"')
bad("collider_without_direction",
    {"/colliders": [{"plugin": "plane", "point": [0, 0, -1], "normal": [0, 0, 0]}]},
    "at /colliders/0", "normal is 0", beyond="plugin")
bad("collider_around_the_sheet",
    {"/colliders": [{"plugin": "sphere", "centre": [0.5, 0.5, 0], "radius": 9}]},
    "at /colliders/0", "inside of this collider", beyond="plugin")
bad("collider_of_an_equilibrium",
    {"/colliders": [{"plugin": "plane", "point": [0, 0, -1]}], "/integrator/plugin": "static"},
    "at /colliders", "equilibria in contact take energies with a potential", beyond="plugin")
bad("collider_path_without_times",
    {"/colliders": [{"plugin": "plane", "point": [0, 0, -1], "displacements": [[0, 0, 0]]}]},
    "at /colliders/0", "'times' has 0 entries, 'displacements' 1", beyond="plugin")
bad("collider_path_backwards",
    {"/colliders": [{"plugin": "plane", "point": [0, 0, -1], "times": [1, 0],
                     "rotations": [[0, 0, 0], [0, 0, 1]]}]},
    "at /colliders/0", "'times' must ascend, but 1 is followed by 0", beyond="plugin")
bad("collider_restitution",
    {"/colliders": [{"plugin": "plane", "point": [0, 0, -1], "restitution": 1.5}]},
    "at /colliders/0/restitution", "found 1.5, expected number >= 0, <= 1")
bad("collider_rounder_than_it_is",
    {"/colliders": [{"plugin": "box", "centre": [0, 0, -9], "rounding": 2}]},
    "at /colliders/0", "rounding is more", beyond="plugin")
bad("key_comment_like", {"/_comment": "x"}, "at /_comment", "a scene has no")

# ---- what is missing ----------------------------------------------------------------------------
bad("no_surface", {"/surface": REMOVE}, ":1:1", '"surface" is missing')
bad("no_integrator", {"/integrator": REMOVE}, ":1:1", '"integrator" is missing')
bad("no_duration", {"/duration": REMOVE}, ":1:1", '"duration" is missing')
bad("no_step", {"/integrator/step": REMOVE}, "at /integrator", '"step" is missing')
bad("no_step_in_short_form", {"/integrator": "semi_implicit"}, "at /integrator", '"step" is missing')
bad("no_nodes", {"/surface/nodes": REMOVE}, "at /surface", '"nodes" is missing')
bad("no_plugin", {"/forces/0/plugin": REMOVE}, "at /forces/0", "the name of the force plugin")
bad("no_where", {"/constraints/0/where": REMOVE}, "at /constraints/0", '"where" is missing')
bad("no_radius_of_selector", {"/forces/0/where/radius": REMOVE}, "at /forces/0/where", '"radius"')
bad("no_centre_of_selector", {"/forces/0/where/centre": REMOVE}, "at /forces/0/where", '"centre"')
bad("no_radius_of_arc", {"/surface/rest": "arc"}, "at /surface/rest", '"radius" is missing')

# ---- types --------------------------------------------------------------------------------------
for name, value in (("list", []), ("number", 1), ("text", "sheet"), ("null", None), ("flag", True)):
    raw(f"scene_is_{name}", json.dumps(value), ":1:1", "expected a scene, which is an object",
        beyond="")
bad("title_is_number", {"/title": 3}, "at /title", "found 3, expected text")
bad("schema_is_number", {"/$schema": 3}, "at /$schema", "found 3, expected text")
bad("duration_is_text", {"/duration": "2"}, "at /duration", 'found "2", expected number > 0')
bad("duration_is_null", {"/duration": None}, "at /duration", "found null, expected number")
bad("duration_is_flag", {"/duration": True}, "at /duration", "found true, expected number")
bad("duration_is_list", {"/duration": [2]}, "at /duration", "found [2], expected number")
bad("material_is_number", {"/material": 0.1}, "at /material", "expected an object")
bad("forces_is_object", {"/forces": {"plugin": "gravity"}}, "at /forces", "expected a list")
bad("energies_is_null", {"/energies": None}, "at /energies", "expected a list")
bad("surface_is_list", {"/surface": [9, 9]}, "at /surface", "expected the surface plugin")
bad("probe_is_number", {"/probes/0": 7}, "at /probes/0", "found 7, expected the probe plugin")
bad("plugin_name_is_number", {"/forces/0/plugin": 7}, "at /forces/0", "the name of the force plugin")
bad("nodes_is_number", {"/surface/nodes": 9}, "at /surface/nodes", "[whole number, whole number]")
bad("nodes_has_three", {"/surface/nodes": [9, 9, 9]}, "at /surface/nodes", "[whole number,")
bad("nodes_not_whole", {"/surface/nodes": [9, 9.5]}, "at /surface/nodes/1", "whole number >= 3")
bad("nodes_is_text", {"/surface/nodes": ["9", 9]}, "at /surface/nodes/0", "whole number >= 3")
bad("velocity_has_two", {"/velocity": [0, 1]}, "at /velocity", "[x, y, z]")
bad("velocity_of_flag", {"/velocity": [0, 0, True]}, "at /velocity/2", "expected number or formula")
bad("velocity_is_null", {"/velocity": None}, "at /velocity", "or {\"linear\", \"spin\", \"about\"}")
bad("velocity_misspelt", {"/velocity": {"linaer": [0, 0, 1]}}, "at /velocity/linaer",
    'velocity has no "linaer"', "linear")
bad("spin_of_formula", {"/velocity": {"spin": [0, 0, "a1"]}}, "at /velocity/spin/2",
    "expected number [rad/s]")
bad("about_is_text", {"/velocity": {"about": "centre"}}, "at /velocity/about", "[x, y, z] [m]")
bad("force_is_number", {"/forces/0/force": -0.01}, "at /forces/0/force", "[x, y, z]")
bad("components_is_text", {"/constraints/0/components": "x"}, "at /constraints/0/components",
    'list of texts, one of "x", "y", "z"')
bad("every_is_fraction", {"/outputs/0/every": 2.5}, "at /outputs/0/every", "whole number >= 1")
bad("periodic_is_number", {"/surface/periodic": 1}, "at /surface/periodic", "true, false")
bad("periodic_has_three", {"/surface/periodic": [True, True, True]}, "at /surface/periodic", "true")
bad("rest_is_number", {"/surface/rest": 1}, "at /surface/rest", "expected the shape plugin")
bad("rest_path_is_number", {"/surface/rest": {"plugin": "file", "path": 1}}, "at /surface/rest/path",
    "file name")
bad("xi_is_object", {"/energies/1/xi": {}}, "at /energies/1/xi", "[[11, 12], [21, 22]]")
bad("xi_has_one_row", {"/energies/1/xi": [[1, 0]]}, "at /energies/1/xi", "[[11, 12], [21, 22]]")
bad("xi_has_short_row", {"/energies/1/xi": [[1, 0], [1]]}, "at /energies/1/xi/1", "[number, number]")
bad("delta_is_other_text", {"/energies/1/normal/delta": "inf"}, "at /energies/1/normal/delta",
    'or "infinity"')
bad("where_is_text", {"/constraints/0/where": "boundary"}, "at /constraints/0/where", '{"boundary"')
bad("where_is_empty_object", {"/constraints/0/where": {}}, "at /constraints/0/where", '{"boundary"')
bad("where_is_empty_list", {"/constraints/0/where": []}, "at /constraints/0/where", '{"boundary"')
bad("where_of_two_forms", {"/constraints/0/where": {"boundary": "all", "node": 1}},
    "at /constraints/0/where/node", "this selector has no")
bad("where_no_names", {"/constraints/0/where": {"boundary": []}}, "at /constraints/0/where/boundary",
    "a name or a list of names")
bad("where_node_is_text", {"/constraints/0/where": {"node": "3"}}, "at /constraints/0/where/node",
    "whole number >= 0")
bad("time_is_text", {"/forces/0/time": "ramp"}, "at /forces/0/time", '{"ramp": [t0, t1]}')
bad("time_of_no_form", {"/forces/0/time": {"step": [0, 1]}}, "at /forces/0/time", '{"ramp": [t0, t1]}')
bad("time_ramp_short", {"/forces/0/time": {"ramp": [1]}}, "at /forces/0/time/ramp", "[number, number]")
bad("time_table_empty", {"/forces/0/time": {"table": []}}, "at /forces/0/time/table", "at least one")

bad("shadow_is_object", {"/shadow": {}}, "at /shadow", "found {}, expected a list of normal plugins")
bad("shadow_is_name", {"/shadow": "exact"}, "at /shadow", 'found "exact", expected a list')
bad("shadow_is_null", {"/shadow": None}, "at /shadow", "found null, expected a list")
bad("shadow_is_number", {"/shadow": ["exact", 1]}, "at /shadow/1", "expected the normal plugin")
bad("shadow_without_plugin", {"/shadow": [{"delta": 1}]}, "at /shadow/0", "the name of the normal plugin")
bad("shadow_parameter_misspelt", {"/shadow": [{"plugin": "gauss", "delt": 1}]}, "at /shadow/0/delt",
    'normal plugin "gauss" has no "delt"', "delta")
bad("shadow_parameter_negative", {"/shadow": [{"plugin": "gauss", "delta": -1}]},
    "at /shadow/0/delta", "found -1, expected number >= 0")

# ---- ranges -------------------------------------------------------------------------------------
bad("density_negative", {"/material/density": -0.1}, "at /material/density", "number > 0 [kg/m²]")
bad("density_zero", {"/material/density": 0}, "at /material/density", "found 0, expected number > 0")
bad("damping_negative", {"/material/damping": -1}, "at /material/damping", "number >= 0")
bad("duration_zero", {"/duration": 0}, "at /duration", "number > 0 [s]")
bad("duration_negative", {"/duration": -2}, "at /duration", "number > 0 [s]")
bad("step_zero", {"/integrator/step": 0}, "at /integrator/step", "number > 0 [s]")
bad("every_zero", {"/outputs/0/every": 0}, "at /outputs/0/every", "whole number >= 1")
bad("every_negative", {"/probes/0": {"plugin": "energy", "every": -3}}, "at /probes/0/every", ">= 1")
bad("xi_negative", {"/energies/1/xi": -1e-6}, "at /energies/1/xi", ">= 0")
bad("xi_negative_component", {"/energies/1/xi": [[1, 0], [0, -1]]}, "at /energies/1/xi/1/1", ">= 0")
bad("radius_negative", {"/forces/0/where/radius": -0.1}, "at /forces/0/where/radius", "number >= 0 [m]")
bad("node_negative", {"/constraints/0/where": {"node": -1}}, "at /constraints/0/where/node", ">= 0")
bad("size_zero", {"/surface/size": [0, 1]}, "at /surface/size/0", "number > 0 [m]")
bad("nodes_zero", {"/surface/nodes": [0, 9]}, "at /surface/nodes/0", "whole number >= 3")
bad("nodes_one", {"/surface/nodes": [9, 1]}, "at /surface/nodes/1", "whole number >= 3")
bad("nodes_minus_three", {"/surface/nodes": [-3, 9]}, "at /surface/nodes/0", "whole number >= 3")
bad("arc_along_3", {"/surface/rest": {"plugin": "arc", "radius": 1, "along": 3}},
    "at /surface/rest/along", "<= 2")
bad("limits_zero", {"/limits": {"distance": 0}}, "at /limits/distance", "number > 0")

# ---- names --------------------------------------------------------------------------------------
bad("plugin_misspelt", {"/energies/0/plugin": "streching"}, "at /energies/0/plugin",
    'there is no energy plugin "streching"', "stretching")
bad("plugin_of_another_kind", {"/forces/0/plugin": "pin"}, "at /forces/0/plugin",
    "there is a plugin constraint/pin")
bad("plugin_unlike_any", {"/surface/plugin": "tetrahedra"}, "at /surface/plugin",
    'valid are "grid", "mesh"')
bad("plugin_name_empty", {"/forces/0/plugin": ""}, "at /forces/0/plugin", "there is no force plugin")
bad("plugin_name_is_path", {"/solver": {"plugin": "../../lib/evil"}}, "at /solver/plugin",
    "there is no solver plugin")
bad("plugin_name_is_long", {"/forces/0/plugin": "x" * 100000}, "at /forces/0/plugin",
    "there is no force plugin")
bad("normal_misspelt", {"/energies/1/normal": "gaus"}, "at /energies/1/normal",
    'there is no normal plugin "gaus"', "gauss")
bad("shadow_misspelt", {"/shadow": ["exact", "gaus"]}, "at /shadow/1",
    'there is no normal plugin "gaus"', "gauss")
bad("shadow_of_another_kind", {"/shadow": ["bending"]}, "at /shadow/0",
    "there is a plugin energy/bending")
bad("probe_misspelt", {"/probes/1": "lowst"}, "at /probes/1", "there is no probe plugin", "lowest")
bad("shape_misspelt", {"/surface/rest": {"plugin": "flatt"}}, "at /surface/rest/plugin",
    "there is no shape plugin", "flat")
bad("solver_misspelt", {"/solver": "cholmodd"}, "at /solver", "no solver plugin", "cholmod")
bad("form_misspelt", {"/energies/1/form": "expandet"}, "at /energies/1/form", "one of", "expanded")
bad("border_misspelt", {"/surface/border": "papers"}, "at /surface/border", "one of", "paper")
bad("differences_unknown", {"/surface/differences": "spectral"}, "at /surface/differences",
    'one of "symmetric", "forward", "central"')
bad("symmetric_with_the_paper_s_border", {"/surface/differences": "symmetric",
    "/surface/border": "paper", "/surface/weights": "area"}, "at /surface/border",
    'expected "one_sided": symmetric differences', beyond="relations")
bad("symmetric_with_equal_weights", {"/surface/differences": "symmetric",
    "/surface/border": "one_sided", "/surface/weights": "equal"}, "at /surface/weights",
    'expected "area": with symmetric differences', beyond="relations")
bad("component_unknown", {"/constraints/0/components": ["x", "w"]}, "at /constraints/0/components/1",
    'one of "x", "y", "z"')
bad("boundary_misspelt", {"/constraints/0/where": {"boundary": "lift"}}, "at /constraints/0/where",
    'no boundary "lift"', "left", beyond="nodes")
bad("corner_misspelt", {"/constraints/0/where": {"corners": ["left_top", "left_botom"]}},
    "at /constraints/0/where", 'no corner "left_botom"', "left_bottom", beyond="nodes")
bad("boundary_of_closed_side", {"/surface/periodic": [True, False], "/surface/rest":
    {"plugin": "arc", "radius": 0.15915494309189535}, "/constraints/0/where": {"boundary": "left"}},
    "at /constraints/0/where", 'no boundary "left"', beyond="nodes")

# ---- nodes --------------------------------------------------------------------------------------
bad("selects_nothing", {"/forces/0/where/centre": [5, 5]}, "at /forces/0/where", "selects no node",
    beyond="nodes")
bad("selects_nothing_between_nodes", {"/constraints/0/where": {"box": [[0.01, 0.01], [0.02, 0.02]]}},
    "at /constraints/0/where", "selects no node of the surface, whose parameters are [0, 0] to [1, 1]",
    beyond="nodes")
bad("node_beyond_the_last", {"/constraints/0/where": {"node": [80, 81]}}, "at /constraints/0/where",
    "no node 81; its nodes are 0 to 80", beyond="nodes")
bad("many_nodes_beyond_the_last", {"/constraints/0/where": {"node": list(range(100000))}},
    "at /constraints/0/where", "no node 81, 82, 83, 84, 85 and 99914 more", beyond="nodes")
bad("box_upside_down", {"/constraints/0/where": {"box": [[1, 1], [0, 0]]}},
    "at /constraints/0/where/box", "a1 <= b1", beyond="order")
bad("grid_of_2_31", {"/surface/nodes": [65536, 32768]}, "at /surface/nodes", "than can be numbered",
    beyond="memory")
bad("grid_of_10_18", {"/surface/nodes": [1000000000, 1000000000]}, "at /surface/nodes",
    "than can be numbered", beyond="memory")
bad("grid_side_of_10_18", {"/surface/nodes": [1000000000000000000, 1000000000000000000]},
    "at /surface/nodes", "than can be numbered", beyond="memory")
bad("grid_beyond_memory", {"/surface/nodes": [46340, 46340]}, "at /surface/nodes", "GB, this machine has",
    beyond="memory")
bad("nodes_as_huge_float", {"/surface/nodes": [1e300, 3]}, "at /surface/nodes/0", "whole number >= 3",
    beyond="spelling")
bad("every_as_huge_float", {"/outputs/0/every": 1e300}, "at /outputs/0/every", "whole number >= 1",
    beyond="spelling")
bad("size_too_small", {"/surface/size": [1e-300, 1]}, "at /surface/size", "too extreme", beyond="plugin")
bad("size_too_large", {"/surface/size": [1, 1e300]}, "at /surface/size", "too extreme", beyond="plugin")

# ---- relations and order ------------------------------------------------------------------------
bad("two_outputs_in_one_folder", {"/outputs/-": {"plugin": "vtk", "every": 2}}, "at /outputs/1",
    "keep one of them", beyond="relations")
bad("step_beyond_duration", {"/integrator/step": 1}, "at /duration", "at least one step, which is 1.0",
    beyond="relations")
bad("too_many_steps", {"/duration": 1e300}, "at /duration", "more than 1e+15 steps", beyond="relations")
bad("too_small_a_step", {"/integrator/step": 1e-300}, "at /duration", "more than 1e+15 steps",
    beyond="relations")
bad("steps_overflow", {"/duration": 1e300, "/integrator/step": 1e-300}, "at /duration",
    "more than 1e+15 steps", beyond="relations")
bad("ramp_backwards", {"/forces/0/time": {"ramp": [1, 0]}}, "at /forces/0/time/ramp", "ascending",
    beyond="order")
bad("pulse_of_no_length", {"/forces/0/time": {"pulse": [1, 1]}}, "at /forces/0/time/pulse",
    "ascending", beyond="order")
bad("table_not_ascending", {"/forces/0/time": {"table": [[0, 0], [1, 1], [0.5, 0]]}},
    "at /forces/0/time/table", "ascending", beyond="order")
bad("xi_unsymmetric", {"/energies/1/xi": [[1, 0.5], [0.25, 1]]}, "at /energies/1/xi",
    "12 must equal 21", beyond="order")
MOVE = {"plugin": "move", "where": {"boundary": "left"}, "times": [0, 1],
        "displacements": [[0, 0, 0], [1, 0, 0]]}
bad("move_lists_differ", {"/constraints/-": {**MOVE, "times": [0, 1, 2]}}, "at /constraints/1",
    "they must be as many", beyond="relations")
bad("move_times_fall", {"/constraints/-": {**MOVE, "times": [1, 0]}}, "at /constraints/1",
    "must ascend", beyond="order")
bad("move_no_times", {"/constraints/-": {**MOVE, "times": [], "displacements": []}},
    "at /constraints/1", "'times' is empty", beyond="plugin")
bad("pin_no_components", {"/constraints/0/components": []}, "at /constraints/0",
    "'components' is empty", beyond="plugin")
bad("second_constraint_is_wrong", {"/constraints/-": {"plugin": "pin", "where": {"node": 99}}},
    "at /constraints/1/where", "no node 99", beyond="nodes")

bad("shadow_of_nothing", {"/shadow": ["exact"], "/energies": ["stretching", "bending_variational"]},
    "at /shadow", "no energy term of this scene takes a normal estimator", beyond="relations")
bad("shadows_of_many_terms", {"/shadow": ["exact"] * 501, "/energies": ["bending"] * 2}, "at /shadow",
    "found 501 shadows of 2 energy terms, expected at most 1000", beyond="relations")

# ---- shapes and files ---------------------------------------------------------------------------
bad("periodic_with_open_shape", {"/surface/periodic": True}, "at /surface/periodic", "does not close",
    beyond="shapes")
bad("periodic_along_the_other_side", {"/surface/periodic": [False, True], "/surface/rest":
    {"plugin": "arc", "radius": 0.15915494309189535}}, "at /surface/periodic", "does not close along a2",
    beyond="shapes")
bad("arc_goes_around_twice", {"/surface/rest": {"plugin": "arc", "radius": 0.1}},
    "at /surface/rest", "more than once around", beyond="shapes")
bad("arc_of_no_side", {"/surface/rest": {"plugin": "arc", "radius": 1, "side": 0}},
    "at /surface/rest", "must be 1 or -1", beyond="plugin")
bad("patch_over_the_pole", {"/surface/rest": {"plugin": "sphere_patch", "radius": 0.25}},
    "at /surface/rest", "a sphere of radius", beyond="shapes")
bad("formula_with_unknown_name", {"/surface/rest": {"plugin": "formula", "z": "sin(b1)"}},
    "at /surface/rest/z", 'there is no "b1"', "a1", beyond="formulas")
bad("velocity_with_unknown_name", {"/velocity": [0, "b1", 0]}, "at /velocity/1",
    'there is no "b1"', "a1", beyond="formulas")
bad("velocity_whose_square_overflows", {"/velocity": [0, 0, 1e155]}, "at /velocity",
    "kinetic energy no number holds", beyond="plugin")
bad("collider_whose_square_overflows",
    {"/colliders": [{"plugin": "sphere", "centre": [0, 0, -1e200], "radius": 1}]},
    "at /colliders/0", "no number holds squares of such sizes", beyond="plugin")
bad("rest_without_area", {"/surface/rest": {"plugin": "formula", "y": "0*a2"}}, "at /surface/rest",
    "no area around node", beyond="plugin")
bad("masses_of_two_materials", {"/material": {}, "/energies": [
    {"plugin": "koiter", "material": "steel"}, {"plugin": "koiter_orthotropic", "material": "paper"}]},
    "at /material/density", "say what the surface weighs", beyond="plugin")
SHELL = {"plugin": "koiter", "young": 1e6, "poisson": 0.3, "thickness": 0.001}
bad("koiter_of_no_stiffness", {"/energies": [SHELL | {"young": 0}]}, "at /energies/0",
    "'young' is 0, expected more than 0", beyond="plugin")
bad("koiter_of_no_thickness", {"/energies": [SHELL | {"thickness": 0, "material": "paper"}]},
    "at /energies/0", "'thickness' is 0, expected more than 0", beyond="plugin")
bad("koiter_without_poisson",
    {"/energies": [{"plugin": "koiter", "young": 1e6, "thickness": 0.001}]}, "at /energies/0",
    "'poisson' is missing: give it, or a 'material'", beyond="plugin")
bad("koiter_of_poisson_minus_one", {"/energies": [SHELL | {"poisson": -1}]},
    "at /energies/0/poisson", "found -1, expected number > -1")
bad("orthotropic_of_no_shear",
    {"/energies": [{"plugin": "koiter_orthotropic", "material": "paper", "shear": 0}]},
    "at /energies/0/shear", "found 0, expected number > 0")
bad("velocity_not_finite", {"/velocity": {"linear": [0, 0, "1/a1"]}}, "at /velocity/linear/2",
    "is inf at a1 = 0", beyond="formulas")
bad("formula_that_ends_early", {"/surface/rest": {"plugin": "formula", "z": "2*("}},
    "at /surface/rest/z", "expected a formula of a1, a2", beyond="formulas")
bad("wave_too_short", {"/surface/initial": {"plugin": "wave", "wavelength": 1e-308}},
    "at /surface/initial", "the number of waves on the surface is not finite",
    beyond="plugin")
bad("formula_not_finite", {"/surface/rest": {"plugin": "formula", "z": "1/a1"}},
    "at /surface/rest", "is inf at a1 = 0", beyond="formulas")
bad("formula_constant_misnamed", {"/surface/rest": {"plugin": "formula", "constants": {"pi": 3}}},
    "at /surface/rest/constants", "has the name of something else", beyond="formulas")
bad("tube_too_thick", {"/surface/rest": {"plugin": "torus", "radius": 1, "tube": 2}},
    "at /surface/rest/tube", "must be thinner", beyond="shapes")
bad("field_with_unknown_name", {"/energies/-": {"plugin": "edge_springs", "stiffness": {"formula": "b1"}}},
    "at /energies/2/stiffness/formula", 'there is no "b1"', "a1", beyond="formulas")
bad("field_out_of_range", {"/energies/-": {"plugin": "edge_springs", "stiffness": {"formula": "a1 - 0.5"}}},
    "at /energies/2/stiffness", "is -0.5 at a1 = 0, a2 = 0", beyond="formulas")
bad("field_of_no_form", {"/energies/-": {"plugin": "edge_springs", "stiffness": {"formule": "a1"}}},
    "at /energies/2/stiffness", "expected number, formula or map")
bad("field_map_missing", {"/energies/-": {"plugin": "edge_springs", "stiffness": {"map": "k.csv"}}},
    "at /energies/2/stiffness/map", "there is no such file", beyond="files")
REST_FILE = {"/surface/rest": {"plugin": "file", "path": "rest.txt"}}


def bad_file(name, content, rule):
    files = {} if content is REMOVE else {"rest.txt": content}
    bad(name, REST_FILE, "at /surface/rest", rule, beyond="files", files=files)


bad_file("file_missing", REMOVE, "there is no such file")
bad_file("file_is_folder", None, "is a folder")
bad_file("file_empty", b"", "has 0 positions, but the surface has 81")
bad_file("file_too_short", shape_file(80), "has 80 positions, but the surface has 81")
bad_file("file_too_long", shape_file(81) + "0 0 0\n", "has more than 81 positions")
bad_file("file_with_nan", shape_file(80) + "nan 0 0\n", "rest.txt:81: 'nan' is not a finite number")
bad_file("file_with_inf", "inf 0 0\n" + shape_file(80), "rest.txt:1: 'inf' is not a finite number")
bad_file("file_with_huge_number", shape_file(80) + "0 1e999 0\n", "rest.txt:81: '1e999' is not")
bad_file("file_with_two_columns", shape_file(3) + "0 0\n", "rest.txt:4: has 2 numbers")
bad_file("file_of_text", "x y z\n", "rest.txt:1: 'x' is not")
bad_file("file_without_lines", b"1" * 100000, "rest.txt:1: is longer than")
bad_file("file_of_bytes", bytes(range(256)), "rest.txt:1: ")
bad("file_path_empty", {"/surface/rest": {"plugin": "file", "path": ""}}, "at /surface/rest",
    "is a folder", beyond="files")
bad("file_path_too_long", {"/surface/rest": {"plugin": "file", "path": "x" * 5000}},
    "at /surface/rest", "cannot be read", beyond="files")
bad("file_path_is_device", {"/surface/rest": {"plugin": "file", "path": "/dev/zero"}},
    "at /surface/rest", "is not a regular file", beyond="files")
bad("initial_file_missing", {"/surface/initial": {"plugin": "file", "path": "no.txt"}},
    "at /surface/initial", "there is no such file", beyond="files")

# ---- variants -----------------------------------------------------------------------------------


def bad_variant(name, changes, place, rule, near="", beyond="pointers", runs=False):
    bad("variant_" + name, {"/variants": {"v": changes}}, place, rule, near, beyond)
    CASES[-1].runs = runs


bad_variant("to_nowhere", {"/energies/1/nrmal/delta": 1}, ":", '/energies/1 has no key "nrmal"', "normal")
bad_variant("to_no_item", {"/energies/7": "stretching"}, ":", '/energies has no item "7", it has 2')
bad_variant("to_inside_a_number", {"/duration/x": 1}, ":", "which has nothing in it")
bad_variant("to_new_key", {"/energies/1/etta": 1}, "at /energies/1/etta",
            'has no "etta"; valid are')
bad_variant("to_wrong_value", {"/duration": -1}, "at /duration", "number > 0", beyond="")
bad_variant("to_deep_wrong_value", {"/energies/1/normal/delta": -1}, "at /energies/1/normal/delta",
            ">= 0")
bad_variant("to_wrong_plugin", {"/energies/1": "bendng"}, "at /energies/1", "no energy plugin",
            "bending", beyond="", runs=True)
bad_variant("to_no_node", {"/forces/0/where/centre": [3, 3]}, "at /forces/0/where", "selects no node",
            runs=True)
bad_variant("to_wrong_shadow", {"/shadow": ["exat"]}, "at /shadow/0", "no normal plugin", "exact",
            beyond="", runs=True)
bad_variant("to_another_shadow", {"/shadow/-": "exat"}, "at /shadow/0", "no normal plugin", "exact",
            beyond="", runs=True)
bad_variant("to_nothing_to_shadow", {"/shadow": ["exact"], "/energies": []}, "at /shadow",
            "takes a normal estimator", beyond="relations")
bad_variant("to_append_to_object", {"/material/-": 1}, "at /material/-", 'material has no "-"')
bad_variant("to_append_in_between", {"/energies/-/eta": 1}, ":", '/energies has no item "-"')
bad_variant("to_no_file", {"/surface/rest": {"plugin": "file", "path": "no.txt"}},
            "at /surface/rest", "there is no such file", beyond="files", runs=True)
bad_variant("without_slash", {"duration": 1}, ":", "no JSON pointer", beyond="")
bad_variant("to_whole_scene", {"": {}}, ":", "no JSON pointer", beyond="")
bad_variant("with_bad_escape", {"/a~2": 1}, ":", "no JSON pointer", beyond="")
bad_variant("of_variants", {"/variants/v": {}}, ":", "variants cannot be replaced", beyond="")
bad_variant("with_leading_zero", {"/energies/01": "stretching"}, ":", 'no item "01"')
bad("variants_is_list", {"/variants": ["a"]}, "at /variants", "expected an object of variants")
bad("variant_is_text", {"/variants": {"v": "heavy"}}, "at /variants/v", "JSON pointers and values")
for name, key in (("path", "../../etc"), ("base", "base"), ("empty", ""), ("dash", "-v"),
                  ("dot", ".hidden"), ("blank", "a b"), ("umlaut", "Größe")):
    bad(f"variant_name_{name}", {"/variants": {key: {}}},
        "at /variants/" + key.replace("/", "~1"), "expected a name of letters, digits")
bad("variants_too_many", {"/variants": {f"v{i}": {} for i in range(1001)}}, "at /variants",
    "found 1001 variants")

# ---- much of it: neither memory nor time may grow beyond bounds ----------------------------------
bad("many_probes", {"/probes": ["energy"] * 100000}, "at /probes",
    "found 100000 probes, expected at most 1000")
bad("many_variants", {"/variants": {f"v{i}": {} for i in range(100000)}}, "at /variants",
    "found 100000 variants")
bad("many_changes", {"/variants": {"v": {f"/x{i}": i for i in range(20000)}}}, "at /variants",
    "which are too many", beyond="pointers")
bad("many_wrong_keys", {f"/x{i}": i for i in range(100000)}, "at /x0", 'a scene has no "x0"')
bad("many_wrong_numbers", {"/constraints/-": {**MOVE, "times": ["x"] * 100000}},
    "at /constraints/1/times/0", 'found "x", expected number')
bad("many_nodes_of_wrong_type", {"/constraints/0/where": {"node": [0.5] * 100000}},
    "at /constraints/0/where/node/0", "found 0.5, expected whole number")
bad("large_value", {"/title": {f"k{i}": list(range(100)) for i in range(2000)}}, "at /title",
    'found {"k0":[0,1,2')

# ---- text ---------------------------------------------------------------------------------------
GOOD_TEXT = text_of({})
raw("empty", "", ":1:1", "the text is empty")
raw("only_comment", "// nothing\n", ":2:1", "the text is empty")
raw("truncated", GOOD_TEXT[:len(GOOD_TEXT) // 2], ":", "the text ends too early")
raw("truncated_in_string", '{"title": "She', ":1:15", "is not closed")
raw("truncated_after_key", '{"title"', ":1:9", "':' after the key")
raw("not_utf8", b'{"title": "\xff"}', ":1:12", "must be UTF-8, found the byte 0xFF")
raw("latin1", '{"title": "Größe"}'.encode("latin-1"), ":1:14", "must be UTF-8")
raw("overlong_utf8", b'{"title": "\xc0\xaf"}', ":1:12", "must be UTF-8")
raw("utf8_surrogate", b'{"title": "\xed\xa0\x80"}', ":1:12", "must be UTF-8")
raw("utf16", GOOD_TEXT.encode("utf-16"), ":1:1", "byte order mark of UTF-16")
raw("nul_byte", b'{"title": "\0"}', ":1:12", "NUL")
raw("nul_escape", GOOD_TEXT.replace("{", '{"title": "\\u0000",', 1), ":1:12", "must not hold \\u0000", beyond="reader")
raw("lone_surrogate", GOOD_TEXT.replace("{", '{"title": "\\ud800",', 1), ":1:12", "a surrogate must be", beyond="reader")
raw("second_byte_order_mark", "\ufeff\ufeff" + GOOD_TEXT, ":1:1", "U+FEFF")
raw("duplicate_key", GOOD_TEXT.replace('"duration"', '"duration": 1,\n "duration"'), ":",
    "only once in an object, found 'duration' again", beyond="reader")
raw("duplicate_keys_by_the_thousand", "{" + '"k": 1, ' * 100000 + '"k": 1}', ":1:10",
    "only once in an object", beyond="")
raw("duplicate_key_deep", GOOD_TEXT.replace('"step"', '"step": 1, "step"'), ":",
    "found 'step' again", beyond="reader")
raw("too_deep", "[" * 65 + "]" * 65, ":1:65", "must not nest deeper than 64", beyond="")
raw("far_too_deep", "[" * 1000000, ":1:65", "must not nest deeper than 64")
raw("deep_value", GOOD_TEXT.replace('"title"', '"x"').replace("{", '{"title": ' + "[" * 70 + "]" * 70 + ",", 1),
    ":1:", "must not nest deeper than 64", beyond="")
for name, word in (("nan", "NaN"), ("infinity", "Infinity"), ("minus_infinity", "-Infinity"),
                   ("nan_lower_case", "nan"), ("inf", "inf")):
    raw("literal_" + name, GOOD_TEXT.replace("0.02", word), ":", "JSON has no")
raw("number_beyond_double", GOOD_TEXT.replace("0.02", "1e400"), ":", "within the range of a double",
    beyond="")
raw("number_below_double", GOOD_TEXT.replace("0.02", "1e-400"), ":", "within the range of a double",
    beyond="")
raw("number_of_many_digits", GOOD_TEXT.replace("0.02", "9" * 400), ":", "the range of a double", beyond="")
raw("number_with_leading_zero", GOOD_TEXT.replace("0.02", "00.02"), ":", "leading zeros")
raw("number_without_zero", GOOD_TEXT.replace("0.02", ".02"), ":", "needs a digit before")
raw("number_ending_in_point", GOOD_TEXT.replace("0.02", "2."), ":", "a digit must follow")
raw("number_with_plus", GOOD_TEXT.replace("0.02", "+0.02"), ":", "must not begin with '+'")
raw("number_hexadecimal", GOOD_TEXT.replace("0.02", "0x10"), ":", "not a decimal number")
raw("word_upper_case", GOOD_TEXT.replace("0.02", "True"), ":", "did you mean true")
raw("trailing_comma", GOOD_TEXT.replace("0.02", "0.02,"), ":", "no trailing comma")
raw("missing_comma", GOOD_TEXT.replace('0.2,', '0.2'), ":", "a ',' is missing")
raw("missing_colon", GOOD_TEXT.replace('"duration":', '"duration"'), ":", "':' after the key 'duration'")
raw("single_quotes", "{'title': 1}", ":1:2", "need double quotes")
raw("bare_key", "{title: 1}", ":1:2", "a key needs double quotes")
raw("block_comment", "/* sheet */" + GOOD_TEXT, ":1:1", "begin each line of one with //")
raw("hash_comment", "# sheet\n" + GOOD_TEXT, ":1:1", "comments begin with //")
raw("wrong_bracket", '{"probes": ["energy"}', ":1:21", "open is the array")
raw("two_values", GOOD_TEXT + "\n{}", ":", "nothing may follow the end")
raw("line_break_in_string", '{"title": "a\nb"}', ":1:11", "must be closed on its line")
raw("tab_in_string", '{"title": "a\tb"}', ":1:13", "must be written \\u0009")
raw("bad_escape", r'{"title": "C:\path"}', ":1:14", "a backslash must be followed by")
raw("key_too_long", '{"' + "k" * 2000 + '": 1}', ":1:2", "must not be longer than 1024", beyond="")

# ---- right --------------------------------------------------------------------------------------
GOOD = {"base": {}}
GOOD.update({
    "short_forms": {"/energies": ["stretching", "bending"], "/probes": ["energy", "flatness"],
                    "/outputs": ["obj"], "/solver": "umfpack", "/surface/rest": "flat"},
    "least": {key: REMOVE for key in ("/material", "/energies", "/forces", "/constraints", "/outputs",
                                      "/probes", "/surface/size")},
    "whole_numbers_as_floats": {"/surface/nodes": [9.0, 9.0], "/outputs/0/every": 5.0},
    "pair_weights": {"/energies/1/xi": [[1e-6, 0], [0, 2e-6]], "/energies/0/eta": [[1, 2], [2, 1]]},
    "infinity": {"/energies/1/normal/delta": "infinity"},
    "time_constant": {"/forces/0/time": 0.5},
    "time_ramp": {"/forces/0/time": {"ramp": [0, 1]}},
    "time_pulse": {"/forces/0/time": {"pulse": [0, 0.1]}},
    "time_table": {"/forces/0/time": {"table": [[0, 0], [1, 1]]}},
    "where_box": {"/constraints/0/where": {"box": [[0, 0], [0.5, 0.5]]}},
    "where_corners": {"/constraints/0/where": {"corners": ["left_top", "right_bottom"]}},
    "where_node": {"/constraints/0/where": {"node": 3}},
    "where_union": {"/constraints/0/where": [{"node": [0, 80]}, {"boundary": ["left", "top"]}]},
    "components": {"/constraints/0/components": ["x", "z"]},
    "move": {"/constraints/-": MOVE},
    "periodic_tube": {"/surface/periodic": [True, False], "/surface/rest":
                      {"plugin": "arc", "radius": 0.15915494309189535}},
    "periodic_flags": {"/surface/periodic": False},
    "wave": {"/surface/initial": {"plugin": "wave", "amplitude": 0.02}},
    "hemisphere": {"/surface/rest": {"plugin": "hemisphere", "radius": 1},
                   "/surface/periodic": [True, False]},
    "torus": {"/surface/rest": {"plugin": "torus", "radius": 1, "tube": 0.3},
              "/surface/periodic": True, "/constraints": []},
    "helicoid": {"/surface/rest": {"plugin": "helicoid", "height": 1}},
    "formula": {"/surface/initial": {"plugin": "formula", "z": "k*sin(2*pi*a1/L1)",
                                     "constants": {"k": 0.01}}},
    "varying": {"/energies/-": {"plugin": "edge_springs", "stiffness": {"formula": "0.01*(1 + a1)"}}},
    "patch": {"/surface/rest": {"plugin": "sphere_patch", "radius": 2}},
    "all_sections": {"/title": "all", "/velocity": [0, 0, 1], "/limits": {"distance": 5},
                     "/$schema": "../scene.schema.json"},
    "velocity_of_formulas": {"/velocity": [0, "a1", "sin(pi*a2)"]},
    "velocity_with_spin": {"/velocity": {"linear": [0, "0.1*a1", 1], "spin": [0, 0, 2],
                                         "about": [0.5, 0.5, 0]}},
    "velocity_in_variants": {"/variants": {"a": {"/velocity": {"spin": [0, 0, 1]}}}},
    "variants": {"/variants": {"a": {}, "b-1e-6=+.": {"/energies/1/normal": "exact",
                                                      "/energies/1/form": "divergence",
                                                      "/material": {"density": 1},
                                                      "/limits/distance": 3}}},
    "shadows": {"/shadow": ["exact", {"plugin": "gauss", "delta": "infinity"}, "gauss"]},
    "no_shadows": {"/shadow": [], "/energies": []},
    "shadow_in_variants": {"/variants": {"a": {"/shadow": ["exact"]}, "b": {"/shadow/-": "exact"}}},
    "many_steps": {"/duration": 2e7},
    "rarely": {"/outputs/0/every": 1000000000000000000},
})


def write_all(folder):
    index = []

    def write(name, text, files=None, **expected):
        place = folder / name
        place.mkdir(parents=True)
        (place / "scene.json").write_bytes(text)
        for file, content in (files or {}).items():
            if content is None:
                (place / file).mkdir()
            else:
                (place / file).write_bytes(content if isinstance(content, bytes) else content.encode())
        index.append({"name": name, "file": f"{name}/scene.json", **expected})

    for case in CASES:
        write(case.name, case.text, case.files, good=False, beyond=case.beyond)
    for name, changes in GOOD.items():
        write("good_" + name, text_of(changes).encode(), good=True, beyond="")
    (folder / "index.json").write_text(json.dumps(index, indent=1), encoding="utf-8")


assert len({case.name for case in CASES}) == len(CASES)
assert all(not case.beyond or case.beyond in BEYOND_SCHEMA for case in CASES)

if __name__ == "__main__":
    write_all(Path(sys.argv[1]))
