#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/error.h"
#include "deform/simulation/scene.h"

#include "json/json.h"
#include "json/json_pointer.h"
#include "plugin/common_parameters.h"

namespace deform {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kScene = R"({
  "$schema": "../schemas/scene.schema.json",
  "title": "Sheet of paper pressed at its centre",  // A comment.
  "surface": { "plugin": "grid", "nodes": [21, 21], "size": [1.0, 1.0],
               "differences": "forward", "border": "paper", "weights": "equal" },
  "material": { "density": 0.1, "damping": 1.0 },
  "energies": [
    { "plugin": "stretching", "eta": 0.01 },
    { "plugin": "bending", "xi": 1e-6, "form": "expanded",
      "normal": { "plugin": "gauss", "delta": 0.5 } }
  ],
  "forces": [ { "plugin": "point_load", "force": [0, 0, -0.01],
                "where": { "centre": [0.5, 0.5], "radius": 0.06 } } ],
  "constraints": [ { "plugin": "pin", "where": { "boundary": "all" } } ],
  "integrator": { "plugin": "semi_implicit", "step": 0.02 },
  "duration": 2.0,
  "outputs": [ { "plugin": "vtk", "every": 5 } ],
  "probes": [ "energy", "lowest" ],
  "variants": {
    "terzopoulos": { "/energies/1/form": "divergence", "/energies/1/normal": "terzopoulos" },
    "stiff": { "/energies/1/xi": [[1e-5, 0], [0, 1e-5]], "/title": "stiff" }
  }
})";

const PluginRegistry& registry() {
  static const PluginRegistry found({DEFORM_PLUGINS, DEFORM_FIXTURE_PLUGINS});
  return found;
}

Scene read(const std::string& text, const std::vector<Replacement>& replacements = {},
           const std::string& variant = "base") {
  return read_scene_text(text, "scene.json", "/scenes", registry(), replacements, variant);
}

std::vector<std::string> messages_of(const std::string& text,
                                     const std::vector<Replacement>& replacements = {},
                                     const std::string& variant = "base") {
  std::vector<std::string> messages;
  try {
    (void)read(text, replacements, variant);
  } catch (const InputError& error) {
    for (const Problem& problem : error.problems()) messages.push_back(problem.message);
  }
  return messages;
}

/// The scene with the value at a JSON pointer replaced; a null takes the key away.
std::string changed(const std::string& pointer, const std::string& value) {
  Json scene = Json::parse(kScene, nullptr, true, true);
  const Json::json_pointer at(pointer);
  const Json replacement = Json::parse(value);
  if (replacement.is_null()) {
    scene[at.parent_pointer()].erase(at.back());
  } else {
    scene[at] = replacement;
  }
  return scene.dump();
}

std::vector<std::string> messages_with(const std::string& pointer, const std::string& value) {
  return messages_of(changed(pointer, value));
}

TEST(SceneReader, ReadsTheWholeScene) {
  const Scene scene = read(kScene);
  EXPECT_EQ(scene.file, "/scenes/scene.json");
  EXPECT_EQ(scene.title, "Sheet of paper pressed at its centre");
  EXPECT_EQ(scene.surface().name, "grid");
  EXPECT_EQ((scene.surface().parameters->get<std::array<std::int64_t, 2>>("nodes")),
            (std::array<std::int64_t, 2>{21, 21}));
  EXPECT_EQ(scene.material.density, 0.1);
  EXPECT_EQ(scene.material.damping, 1.0);
  ASSERT_EQ(scene.plugins[PluginKind::energy].size(), 2U);
  EXPECT_EQ(scene.plugins[PluginKind::energy][1].pointer, "/energies/1");
  EXPECT_EQ(scene.plugins[PluginKind::energy][1].parameters->get<PairWeights>("xi").w,
            (std::array<double, 3>{1e-6, 1e-6, 1e-6}));
  const auto& normal = scene.plugins[PluginKind::energy][1].parameters->get<PluginUse>("normal");
  EXPECT_EQ(normal.name, "gauss");
  EXPECT_EQ(normal.kind, PluginKind::normal);
  EXPECT_EQ(normal.pointer, "/energies/1/normal");
  EXPECT_EQ(normal.parameters->get<double>("delta"), 0.5);
  const auto& where = scene.plugins[PluginKind::force][0].parameters->get<NodeSelection>("where");
  EXPECT_EQ(where.selectors.at(0).radius, 0.06);
  EXPECT_EQ(scene.plugins[PluginKind::constraint][0]
                .parameters->get<NodeSelection>("where")
                .selectors[0]
                .names,
            std::vector<std::string>{"all"});
  EXPECT_EQ(scene.step, 0.02);
  EXPECT_EQ(scene.steps(), 100);
  EXPECT_TRUE(scene.plugins[PluginKind::solver].empty());
  EXPECT_EQ(common_parameters<Output>(scene.plugins[PluginKind::output][0]).every, 5);
  const PluginUse& lowest = scene.plugins[PluginKind::probe][1];
  EXPECT_EQ(lowest.name, "lowest");
  EXPECT_EQ(lowest.pointer, "/probes/1");
  EXPECT_EQ(common_parameters<Probe>(lowest).every, 1);
  for (const Field& component : scene.velocity.linear) {
    EXPECT_TRUE(component.is_constant());
    EXPECT_EQ(component.constant(), 0);
  }
  EXPECT_EQ(scene.velocity.spin, Vec3(0, 0, 0));
  EXPECT_FALSE(scene.velocity.about.has_value());
  EXPECT_EQ(scene.max_distance, 10);
  EXPECT_THAT(scene.variants, ElementsAre("terzopoulos", "stiff"));
}

TEST(SceneReader, CompletesTheSceneInItsOwnOrder) {
  const Json completed = Json::parse(read(kScene).completed);
  std::vector<std::string> keys;
  for (const auto& member : completed.items()) keys.push_back(member.key());
  EXPECT_THAT(keys, ElementsAre("title", "surface", "material", "energies", "forces", "constraints",
                                "integrator", "duration", "outputs", "probes", "colliders",
                                "velocity", "limits", "checkpoint", "frames", "shadow"));
  EXPECT_EQ(completed["velocity"], Json::array({0.0, 0.0, 0.0}));
  EXPECT_EQ(completed["limits"]["distance"], 10.0);
  EXPECT_EQ(completed["probes"][1], (Json{{"plugin", "lowest"}, {"every", 1}}));
  EXPECT_EQ(completed["forces"][0]["time"], 1.0);
  EXPECT_EQ(completed["surface"]["periodic"], Json::array({false, false}));
  EXPECT_EQ(completed["surface"]["rest"]["plugin"], "flat");
  EXPECT_TRUE(completed["surface"]["rest"].contains("origin"));  // The nested plugin's default.
  EXPECT_EQ(completed["energies"][0].begin().key(), "plugin");
}

TEST(SceneReader, CompletedScenesReadBackUnchanged) {
  const std::string minimal = R"({"surface": {"plugin": "grid", "nodes": [3, 4]},
    "integrator": {"plugin": "semi_implicit", "step": 0.1}, "duration": 1,
    "energies": ["bending"], "forces": ["every_type"]})";
  for (const auto& [text, variant] :
       {std::pair(kScene, "base"), {kScene, "terzopoulos"}, {kScene, "stiff"}, {minimal, "base"}}) {
    const Scene scene = read(text, {}, variant);
    const Scene again = read_scene_text(scene.completed, "scene.json", "/elsewhere", registry());
    EXPECT_EQ(again.completed, scene.completed);
    EXPECT_EQ(again.title, scene.title);
    EXPECT_EQ(again.steps(), scene.steps());
    EXPECT_THAT(again.variants, IsEmpty());
  }
}

TEST(SceneReader, AppliesVariants) {
  EXPECT_EQ(read(kScene, {}, "stiff").title, "stiff");
  EXPECT_EQ(
      read(kScene, {}, "stiff").plugins[PluginKind::energy][1].parameters->get<PairWeights>("xi").w,
      (std::array<double, 3>{1e-5, 0, 1e-5}));
  const Scene scene = read(kScene, {}, "terzopoulos");
  EXPECT_EQ(scene.plugins[PluginKind::energy][1].parameters->get<PluginUse>("normal").name,
            "terzopoulos");
  EXPECT_EQ(scene.plugins[PluginKind::energy][1].parameters->get<std::string>("form"),
            "divergence");
}

TEST(SceneReader, RejectsUnknownVariants) {
  EXPECT_THAT(messages_of(kScene, {}, "stif"),
              ElementsAre("scene.json: there is no variant \"stif\"; did you mean \"stiff\"?"));
}

TEST(SceneReader, ChecksEveryVariant) {
  EXPECT_THAT(messages_with("/variants/stiff", R"({"/energies/1/xi": -1, "/energies/2/xi": 1,
                                                  "/surface/nods": [2, 2], "/duration": 0.001})"),
              testing::UnorderedElementsAre(
                  AllOf(HasSubstr("variant \"stiff\": at /energies/1/xi: found -1, expected")),
                  HasSubstr("/energies has no item \"2\", it has 2"),
                  HasSubstr("has no \"nods\"; did you mean \"nodes\"?"),
                  HasSubstr("expected at least one step, which is 0.02 [s]")));
  EXPECT_THAT(messages_with("/variants/base", "{}"), ElementsAre(HasSubstr("not \"base\"")));
  EXPECT_THAT(messages_with("/variants/stiff", "3"), ElementsAre(HasSubstr("found 3, expected")));
  EXPECT_THAT(messages_with("/variants", "3"), ElementsAre(HasSubstr("found 3, expected")));
}

TEST(SceneReader, VariantNamesAreSafeFileNames) {
  std::string text = kScene;
  text.replace(text.find("\"stiff\""), 7, "\"../up\"");
  EXPECT_THAT(messages_of(text), ElementsAre(HasSubstr("found \"../up\", expected a name")));
}

TEST(SceneReader, SaysWhereAVariantsValueStands) {
  std::string text = kScene;
  text.replace(text.find("[[1e-5, 0]"), 10, "[[1e-5, 2]");
  EXPECT_THAT(messages_of(text),
              ElementsAre("scene.json:21:34: variant \"stiff\": at /energies/1/xi: found "
                          "[[1e-05,2],[0,1e-05]], expected a symmetric [[11, 12], [21, 22]]: 12 "
                          "must equal 21"));
}

TEST(SceneReader, LocatesProblemsThatAreFoundLater) {
  const Scene stiff = read(kScene, {{"/duration", "3"}}, "stiff");
  const auto located = [&stiff](const std::string& pointer) {
    return stiff.located({pointer, "at " + pointer + ": wrong"}).message;
  };
  EXPECT_EQ(located("/surface/nodes"),
            "scene.json:4:43: variant \"stiff\": at /surface/nodes: wrong");
  EXPECT_THAT(located("/energies/1/xi"), HasSubstr("scene.json:21:"));
  EXPECT_THAT(located("/energies/1"), HasSubstr("scene.json:21:"));  // What was changed in it.
  EXPECT_THAT(located("/duration"), HasSubstr("--set /duration: "));
  const Problem once = stiff.located({"/surface", "wrong"});
  EXPECT_EQ(stiff.located(once).message, once.message);
}

TEST(SceneReader, ReportsAProblemOfTheBaseOnce) {
  EXPECT_THAT(messages_with("/duration", "-1"), ElementsAre(HasSubstr("at /duration: found -1")));
}

TEST(SceneReader, AppliesReplacements) {
  const Scene scene = read(kScene,
                           {{"/duration", "4"},
                            {"/title", "plain text"},
                            {"/forces/0/time", R"({"ramp": [0, 1]})"},
                            {"/material/damping", "0.25"}},
                           "stiff");
  EXPECT_EQ(scene.duration, 4);
  EXPECT_EQ(scene.title, "plain text");
  EXPECT_EQ(scene.plugins[PluginKind::force][0].parameters->get<TimeProfile>("time").form,
            TimeProfile::Form::ramp);
  EXPECT_EQ(scene.material.damping, 0.25);
}

TEST(SceneReader, ReplacesWithinDefaultsAndShortForms) {
  const Scene rare = read(kScene, {{"/probes/0/every", "7"}});
  EXPECT_EQ(common_parameters<Probe>(rare.plugins[PluginKind::probe][0]).every, 7);
  EXPECT_EQ(read(kScene, {{"/limits/distance", "3"}}).max_distance, 3);
  const Scene scene = read(kScene, {{"/surface/rest/origin", "[1, 2, 3]"}});
  EXPECT_EQ(scene.surface().parameters->get<PluginUse>("rest").parameters->get<Vec3>("origin"),
            Vec3(1, 2, 3));
  const Scene exact =
      read(kScene, {{"/energies/1/normal", "gauss"}, {"/energies/1/normal/delta", "infinity"}});
  EXPECT_EQ(exact.plugins[PluginKind::energy][1]
                .parameters->get<PluginUse>("normal")
                .parameters->get<double>("delta"),
            kInfinity);
}

TEST(SceneReader, AppendsToLists) {
  const Scene scene = read(kScene, {{"/shadow/-", "exact", false, "--shadow"},
                                    {"/shadow/-", R"({"plugin": "gauss"})"},
                                    {"/energies/-", "stretching"}});
  EXPECT_EQ(scene.plugins[PluginKind::energy].size(), 3U);
  ASSERT_EQ(scene.shadows.size(), 2U);
  EXPECT_EQ(scene.place("/shadow/0"), "--shadow /shadow/0");
  EXPECT_EQ(scene.place("/shadow/1"), "--set /shadow/1");
  EXPECT_EQ(scene.place("/energies/2"), "--set /energies/2");
  EXPECT_THAT(
      messages_of(kScene, {{"/shadow/-", "exact"}, {"/shadow/-", "exat", false, "--shadow"}}),
      ElementsAre(AllOf(HasSubstr("--shadow /shadow/1: at /shadow/1: there is no normal plugin"),
                        HasSubstr("did you mean \"exact\"?"))));
}

TEST(SceneReader, MakesAShadowOfEveryTermThatTakesANormal) {
  const std::string text =
      changed("/shadow", R"(["exact", "gauss", {"plugin": "gauss", "delta": 1}])");
  const Scene scene = read(text, {{"/energies/-", R"({"plugin": "bending", "xi": 2})"}});
  ASSERT_EQ(scene.shadows.size(), 6U);
  const std::vector<std::string> names{"exact", "exact", "gauss", "gauss", "gauss_2", "gauss_2"};
  for (std::size_t i = 0; i < 6; ++i) {
    const ShadowUse& shadow = scene.shadows[i];
    EXPECT_EQ(shadow.name, names[i]);
    EXPECT_EQ(shadow.term, i % 2 == 0 ? 1U : 2U);
    EXPECT_EQ(shadow.energy.name, "bending");
    EXPECT_EQ(shadow.energy.pointer, "/shadow/" + std::to_string(i / 2));
    const ParameterValues& own = *scene.plugins[PluginKind::energy][shadow.term].parameters;
    const ParameterValues& values = *shadow.energy.parameters;
    EXPECT_EQ(values.entries().size(), own.entries().size());
    EXPECT_EQ(values.get<PairWeights>("xi").w, own.get<PairWeights>("xi").w);
    EXPECT_EQ(values.get<std::string>("form"), own.get<std::string>("form"));
    EXPECT_EQ(values.get<PluginUse>("normal").parameters, shadow.normal.parameters);
  }
  EXPECT_EQ(scene.shadows[2].normal.parameters->get<double>("delta"), 0.5);
  EXPECT_EQ(scene.shadows[4].normal.parameters->get<double>("delta"), 1);
  const Json completed = Json::parse(scene.completed);
  EXPECT_EQ(completed["shadow"][0], Json({{"plugin", "exact"}}));
  EXPECT_EQ(completed["shadow"][2]["delta"], 1);
  EXPECT_EQ(Json::parse(read(kScene).completed)["shadow"], Json::array());
}

TEST(SceneReader, AShadowNeedsATermThatTakesANormal) {
  const Replacement none{"/energies", R"(["stretching", "bending_variational"])"};
  EXPECT_THAT(messages_of(changed("/shadow", R"(["exact"])"), {none}),
              ElementsAre(HasSubstr("at /shadow: no energy term of this scene takes a normal")));
  // What a term takes that there is not is not known.
  EXPECT_THAT(messages_of(changed("/shadow", R"(["exact"])"), {{"/energies", R"(["bendin"])"}}),
              ElementsAre(HasSubstr("did you mean \"bending\"?")));
}

TEST(SceneReader, RejectsReplacementsThatLeadNowhere) {
  EXPECT_THAT(messages_of(kScene, {{"/energis/1/xi", "1"},
                                   {"/energies/01/xi", "1"},
                                   {"duration", "1"},
                                   {"", "1"},
                                   {"/title/x", "1"},
                                   {"/variants/stiff", "{}"},
                                   {"/duration", "\"long\""},
                                   {"/title", "\xff"}}),
              ElementsAre("--set /energis/1/xi: the scene has no key \"energis\"; did you mean "
                          "\"energies\"?",
                          "--set /energies/01/xi: /energies has no item \"01\", it has 2",
                          HasSubstr("--set duration: this is no JSON pointer"),
                          HasSubstr("--set : this is no JSON pointer"),
                          HasSubstr("--set /title/x: /title is \"Sheet"),
                          "--set /variants/stiff: variants cannot be replaced",
                          "--set /title: the value is not UTF-8",
                          "--set /duration: at /duration: found \"long\", expected number > 0 "
                          "[s]"));
}

TEST(SceneReader, ReportsEveryProblemInTheOrderOfTheFile) {
  EXPECT_THAT(
      messages_of(R"({
  "titel": "x",
  "surface": {"plugin": "grid", "nodes": [1, 21], "differences": "foward"},
  "material": {"density": 0, "damping": "much"},
  "energies": [{"plugin": "bendin"}, {"xi": 1}, 5, {"plugin": "stretching", "et": 1}],
  "forces": {},
  "colliders": 3,
  "integrator": {"plugin": "semi_implicit"},
  "duration": 0
})"),
      ElementsAre(
          "scene.json:2:3: at /titel: a scene has no \"titel\"; did you mean \"title\"?",
          "scene.json:3:43: at /surface/nodes/0: found 1, expected whole number >= 3",
          AllOf(HasSubstr("scene.json:3:66: at /surface/differences: found \"foward\", expected "
                          "one of \"symmetric\", \"forward\", \"central\""),
                HasSubstr("did you mean \"forward\"?")),
          "scene.json:4:27: at /material/density: found 0, expected number > 0 [kg/m²]",
          "scene.json:4:41: at /material/damping: found \"much\", expected number >= 0 [N·s/m³]",
          AllOf(HasSubstr("scene.json:5:27: at /energies/0/plugin: there is no energy plugin "
                          "\"bendin\"; did you mean \"bending\"?"),
                HasSubstr("searched: ")),
          HasSubstr(
              "scene.json:5:38: at /energies/1: \"plugin\", the name of the energy plugin, is "
              "missing"),
          HasSubstr("scene.json:5:49: at /energies/2: found 5, expected the energy plugin"),
          "scene.json:5:77: at /energies/3/et: energy plugin \"stretching\" has no \"et\"; did you "
          "mean \"eta\"?",
          HasSubstr("scene.json:6:13: at /forces: found {}, expected a list of force plugins"),
          HasSubstr("scene.json:7:16: at /colliders: found 3, expected a list of collider plugins"),
          HasSubstr("scene.json:8:17: at /integrator: \"step\" is missing: number > 0 [s]"),
          "scene.json:9:15: at /duration: found 0, expected number > 0 [s]"));
}

TEST(SceneReader, SaysWhatIsMissing) {
  EXPECT_THAT(messages_of("{}"), ElementsAre(HasSubstr("scene.json:1:1: \"surface\" is missing"),
                                             HasSubstr("\"integrator\" is missing"),
                                             HasSubstr("\"duration\" is missing")));
  EXPECT_THAT(messages_of("[]"), ElementsAre(HasSubstr("expected a scene")));
  EXPECT_THAT(messages_of("{"), ElementsAre(HasSubstr("scene.json:1:2: ")));
  EXPECT_THAT(messages_of("{\"title\": \"\", \"title\": \"\"}"),
              ElementsAre(HasSubstr("scene.json:1:15: at /title: ")));
}

TEST(SceneReader, ReadsVelocitiesAtFirst) {
  const InitialVelocity plain = read(changed("/velocity", R"([1, "2*a1", -3])")).velocity;
  EXPECT_EQ(plain.linear[0].constant(), 1);
  EXPECT_EQ(plain.linear[1].source(), "2*a1");
  EXPECT_EQ(plain.linear[2].constant(), -3);
  EXPECT_EQ(plain.spin, Vec3(0, 0, 0));
  const InitialVelocity turning =
      read(changed("/velocity", R"({"spin": [1, 2, 3], "about": [4, 5, 6]})")).velocity;
  EXPECT_EQ(turning.linear[0].constant(), 0);
  EXPECT_EQ(turning.spin, Vec3(1, 2, 3));
  EXPECT_EQ(turning.about, Vec3(4, 5, 6));
}

TEST(SceneReader, CompletesVelocities) {
  const auto completed = [](const std::string& velocity) {
    const std::string text = read(changed("/velocity", velocity)).completed;
    EXPECT_EQ(read(text).completed, text);
    return Json::parse(text)["velocity"];
  };
  EXPECT_EQ(completed(R"([1, "a1", 2.5])"), Json::parse(R"([1, "a1", 2.5])"));
  EXPECT_EQ(completed("{}"),
            Json::parse(R"({"linear": [0.0, 0.0, 0.0], "spin": [0.0, 0.0, 0.0]})"));
  EXPECT_EQ(completed(R"({"about": [1, 2, 3], "spin": [0, 0, 1]})"),
            Json::parse(R"({"about": [1, 2, 3], "spin": [0, 0, 1], "linear": [0.0, 0.0, 0.0]})"));
}

TEST(SceneReader, RejectsVelocities) {
  const auto says = [](const std::string& velocity, const std::string& what) {
    const auto found = messages_of(changed("/velocity", velocity));
    ASSERT_EQ(found.size(), 1U) << velocity;
    EXPECT_THAT(found[0], HasSubstr(what)) << velocity;
  };
  says("3",
       "at /velocity: found 3, expected [x, y, z] of numbers and formulas [m/s], or {\"linear\"");
  says("[1, 2]", "at /velocity: found [1,2], expected [x, y, z] of numbers and formulas [m/s]");
  says("[1, 2, true]", "at /velocity/2: found true, expected number or formula [m/s]");
  says(R"([1, "b1", 2])", "at /velocity/1: ");
  says(R"([1, "b1", 2])", "there is no \"b1\"");
  says(R"({"linear": [0, null, 0]})", "at /velocity/linear/1: found null, expected number or");
  says(R"({"spin": 2})", "at /velocity/spin: found 2, expected [x, y, z] [rad/s]");
  says(R"({"spin": ["a1", 0, 0]})", "at /velocity/spin/0: found \"a1\", expected number [rad/s]");
  says(R"({"about": [0, 0]})", "at /velocity/about: found [0,0], expected [x, y, z] [m]");
  says(R"({"spinn": [0, 0, 1]})", "at /velocity/spinn: velocity has no \"spinn\"; did you mean");
  EXPECT_EQ(messages_of(changed("/velocity", R"({"linear": 1, "spin": 2, "about": 3})")).size(),
            3U);
}

TEST(SceneReader, ANullVelocityIsNone) {
  const std::string text = R"({"surface": {"plugin": "grid", "nodes": [3, 4]}, "duration": 1,
    "integrator": {"plugin": "semi_implicit", "step": 0.1}, "velocity": null})";
  EXPECT_THAT(messages_of(text), ElementsAre(HasSubstr("at /velocity: found null, expected [x")));
}

TEST(SceneReader, ADurationIsAtLeastOneStep) {
  EXPECT_THAT(messages_with("/duration", "0.009"), ElementsAre(HasSubstr("at least one step")));
  EXPECT_THAT(messages_with("/duration", "1e300"), ElementsAre(HasSubstr("more than")));
  EXPECT_EQ(read(changed("/duration", "0.011")).steps(), 1);
}

TEST(SceneReader, ReadsFiles) {
  const auto file = std::filesystem::path(testing::TempDir()) / "scene_reader_test.json";
  std::ofstream(file) << kScene;
  EXPECT_EQ(read_scene(file, registry()).file, file);
  std::filesystem::remove(file);
  EXPECT_THROW((void)read_scene(file, registry()), InputError);
}

// --- Types of parameters, by the fixture that has one of each ---

std::string with_parameters(const std::string& parameters) {
  return R"({"surface": {"plugin": "grid", "nodes": [3, 3]}, "duration": 1,
    "integrator": {"plugin": "semi_implicit", "step": 0.1},
    "forces": [{"plugin": "every_type", )" +
         parameters + "}]}";
}

template <class T>
T value_of(const std::string& name, const std::string& json) {
  const Scene scene = read(with_parameters('"' + name + "\": " + json));
  return scene.plugins[PluginKind::force][0].parameters->get<T>(name);
}

/// What is said of a parameter's value, without its place.
std::string complaint(const std::string& name, const std::string& json) {
  const auto messages = messages_of(with_parameters('"' + name + "\": " + json));
  if (messages.size() != 1) return std::to_string(messages.size()) + " messages";
  const std::size_t place = messages[0].find("at /forces/0/");
  return messages[0].substr(place + 13);
}

TEST(SceneValues, ReadsNumbersAndFlags) {
  EXPECT_EQ(value_of<bool>("flag", "false"), false);
  EXPECT_EQ(value_of<std::int64_t>("small", "2.0"), 2);
  EXPECT_EQ(value_of<std::int64_t>("whole", "-9223372036854775808"),
            std::numeric_limits<std::int64_t>::min());
  EXPECT_EQ(value_of<double>("number", "1"), 1);
  EXPECT_EQ(value_of<double>("limit", "\"infinity\""), kInfinity);
  EXPECT_EQ(value_of<double>("unsaid", "2"), 2);
  EXPECT_EQ(value_of<Vec2>("pair", "[1, 2.5]"), Vec2(1, 2.5));
  EXPECT_EQ(value_of<std::vector<double>>("numbers", "[]"), std::vector<double>{});
  EXPECT_EQ((value_of<std::array<bool, 2>>("both", "true")), (std::array{true, true}));
  EXPECT_EQ((value_of<std::array<bool, 2>>("both", "[true, false]")), (std::array{true, false}));
  EXPECT_EQ(value_of<std::vector<bool>>("flags", "true"), (std::vector<bool>{true, true, true}));
  EXPECT_EQ(value_of<std::vector<Vec3>>("places", "[[1,2,3], [4,5,6]]")[1], Vec3(4, 5, 6));
  EXPECT_EQ(value_of<std::vector<std::string>>("texts", "[\"z\"]"), std::vector<std::string>{"z"});
}

TEST(SceneValues, RejectsNumbersAndFlags) {
  EXPECT_EQ(complaint("flag", "1"), "flag: found 1, expected true or false");
  EXPECT_EQ(complaint("small", "0"), "small: found 0, expected whole number >= 1, <= 2147483647");
  EXPECT_THAT(complaint("small", "5000000000"), HasSubstr("found 5000000000, expected whole"));
  EXPECT_EQ(complaint("whole", "0.5"), "whole: found 0.5, expected whole number");
  EXPECT_EQ(complaint("whole", "1e300"), "whole: found 1e+300, expected whole number");
  EXPECT_EQ(complaint("number", "1.5"), "number: found 1.5, expected number >= 0, <= 1 [1/m]");
  EXPECT_EQ(complaint("number", "\"infinity\""),
            "number: found \"infinity\", expected number >= 0, <= 1 [1/m]");
  EXPECT_EQ(complaint("limit", "0"), "limit: found 0, expected number > 0, or \"infinity\" [s]");
  EXPECT_EQ(complaint("limit", "null"),
            "limit: found null, expected number > 0, or \"infinity\" [s]");
  EXPECT_EQ(complaint("text", "[]"), "text: found [], expected text");
  EXPECT_EQ(complaint("choice", "\"lft\""),
            "choice: found \"lft\", expected one of \"left\", \"right\"; did you mean \"left\"?");
  EXPECT_EQ(complaint("pair", "[1, 2, 3]"),
            "pair: found [1,2,3], expected [number, number] > 0 [m]");
  EXPECT_EQ(complaint("pair", "[1, 0]"), "pair/1: found 0, expected number > 0 [m]");
  EXPECT_EQ(complaint("vector", "[1, 2]"), "vector: found [1,2], expected [x, y, z] [N]");
  EXPECT_EQ(complaint("numbers", "1"), "numbers: found 1, expected list of numbers");
  EXPECT_EQ(complaint("numbers", "[1, \"a\"]"), "numbers/1: found \"a\", expected number");
  EXPECT_EQ(complaint("wholes", "[-1]"), "wholes/0: found -1, expected whole number >= 0");
  EXPECT_EQ(complaint("counts", "[2, 1]"), "counts/1: found 1, expected whole number >= 2");
  EXPECT_THAT(complaint("both", "[true]"), HasSubstr("expected true, false or two of them"));
  EXPECT_THAT(complaint("flags", "[1]"), HasSubstr("flags/0: found 1, expected true or false"));
  EXPECT_THAT(complaint("texts", "[\"w\"]"),
              HasSubstr("texts/0: found \"w\", expected list of texts, one of"));
  EXPECT_THAT(complaint("places", "[[1, 2]]"), HasSubstr("places/0: found [1,2]"));
  EXPECT_THAT(complaint("file", "1"), HasSubstr("file: found 1, expected file name"));
}

TEST(SceneValues, ReadsPairWeights) {
  using Weights = std::array<double, 3>;
  EXPECT_EQ(value_of<PairWeights>("weights", "2").w, (Weights{2, 2, 2}));
  EXPECT_EQ(value_of<PairWeights>("weights", "[[1, 2], [2, 3]]").w, (Weights{1, 2, 3}));
  EXPECT_THAT(complaint("weights", "[[1, 2], [3, 4]]"), HasSubstr("symmetric"));
  EXPECT_THAT(complaint("weights", "[[1, 2], [2, -4]]"),
              HasSubstr("weights/1/1: found -4, expected number >= 0 [N/m]"));
  EXPECT_THAT(complaint("weights", "[1, 2, 3]"),
              HasSubstr("expected number or [[11, 12], [21, 22]] >= 0 [N/m]"));
  EXPECT_THAT(complaint("weights", "-1"), HasSubstr("weights: found -1, expected number >= 0"));
}

TEST(SceneValues, ReadsTimeProfiles) {
  EXPECT_EQ(value_of<TimeProfile>("time", "0.5")(3), 0.5);
  EXPECT_EQ(value_of<TimeProfile>("time", R"({"ramp": [1, 3]})")(2), 0.5);
  EXPECT_EQ(value_of<TimeProfile>("time", R"({"pulse": [1, 3]})")(2), 1);
  EXPECT_EQ(value_of<TimeProfile>("time", R"({"table": [[0, 1], [1, 3]]})")(0.5), 2);
  EXPECT_THAT(complaint("time", R"({"ramp": [3, 1]})"),
              HasSubstr("time/ramp: found [3,1], expected ascending times"));
  EXPECT_THAT(complaint("time", R"({"table": [[0, 1], [0, 3]]})"), HasSubstr("ascending times"));
  EXPECT_THAT(complaint("time", R"({"table": []})"), HasSubstr("at least one"));
  EXPECT_THAT(complaint("time", R"({"table": [[0]]})"), HasSubstr("time/table/0: found [0]"));
  EXPECT_THAT(complaint("time", R"({"rmp": [1, 3]})"), HasSubstr("{\"ramp\": [t0, t1]}"));
  EXPECT_THAT(complaint("time", R"({"ramp": [1, 3], "pulse": [1, 3]})"), HasSubstr("expected a"));
}

TEST(SceneValues, ReadsFields) {
  const ParameterRectangle within{Vec2(0, 0), Vec2(1, 1)};
  EXPECT_EQ(value_of<Field>("field", "2").constant(), 2);
  const Field formula = value_of<Field>("field", R"({"formula": "1 + a1*a2"})");
  EXPECT_DOUBLE_EQ(formula(Vec2(0.5, 0.5), within), 1.25);
  EXPECT_THROW((void)formula(Vec2(2, 1), within), InputError);  // at most 2: the field's range
  const auto weights = [&](const std::string& json) {
    return value_of<PairWeightsField>("weights_field", json)(Vec2(0.25, 0), within).w;
  };
  EXPECT_EQ(weights("3"), (std::array{3.0, 3.0, 3.0}));
  EXPECT_EQ(weights(R"({"formula": "a1"})"), (std::array{0.25, 0.25, 0.25}));
  EXPECT_EQ(weights(R"([[1, {"formula": "a1"}], [{"formula": "a1"}, 3]])"),
            (std::array{1.0, 0.25, 3.0}));
  EXPECT_EQ(value_of<NamedNumbers>("named", R"({"k": 1, "m": 2.5})"),
            (NamedNumbers{{"k", 1}, {"m", 2.5}}));
}

TEST(SceneValues, ReadsMapsFromTheScenesFolder) {
  const auto folder = std::filesystem::path(testing::TempDir());
  std::ofstream(folder / "scene_reader_map.csv") << "1 2\n1 2\n";
  const std::string scene = with_parameters(R"("field": {"map": "scene_reader_map.csv"})");
  const Scene read = read_scene_text(scene, "scene.json", folder, registry());
  const auto field = read.plugins[PluginKind::force][0].parameters->get<Field>("field");
  EXPECT_DOUBLE_EQ(field(Vec2(0.5, 0), {Vec2(0, 0), Vec2(1, 1)}), 1.5);
  EXPECT_EQ(Json::parse(read.completed)["forces"][0]["field"]["map"],
            (folder / "scene_reader_map.csv").lexically_normal().string());
  EXPECT_EQ(read_scene_text(read.completed, "scene.json", "/elsewhere", registry()).completed,
            read.completed);
  std::filesystem::remove(folder / "scene_reader_map.csv");
}

TEST(SceneValues, RejectsFields) {
  EXPECT_EQ(complaint("field", "0"), "field: found 0, expected number > 0, <= 2 [m]");
  EXPECT_EQ(complaint("field", "[1]"),
            "field: found [1], expected number, formula or map > 0, <= 2 [m]");
  EXPECT_THAT(complaint("field", R"({"formule": "1"})"), HasSubstr("expected number, formula or"));
  EXPECT_THAT(complaint("field", R"({"formula": 1})"), HasSubstr("expected number, formula or"));
  EXPECT_EQ(complaint("field", R"({"formula": "a1 + b2"})"),
            "field/formula: found \"a1 + b2\", expected a formula of a1, a2: there is no \"b2\"; "
            "did you mean \"a2\"?");
  EXPECT_THAT(complaint("field", R"({"map": "missing.csv"})"),
              HasSubstr("missing.csv: there is no such file"));
  EXPECT_THAT(complaint("weights_field", R"([[1, {"formula": "1"}], [1, 1]])"),
              HasSubstr("12 must equal 21"));
  EXPECT_THAT(complaint("weights_field", R"([[1, {"formula": "x"}], [{"formula": "1"}, 1]])"),
              HasSubstr("weights_field/0/1/formula: found \"x\""));
  EXPECT_THAT(complaint("weights_field", "[1, 2]"), HasSubstr("expected number, formula or map"));
  EXPECT_THAT(complaint("weights_field", "[[1, -1], [-1, 1]]"), HasSubstr("2 messages"));
  EXPECT_EQ(complaint("named", R"({"k": 11})"), "named/k: found 11, expected number <= 10");
  EXPECT_EQ(complaint("named", "1"), "named: found 1, expected object of numbers <= 10");
}

TEST(SceneValues, ReadsSelections) {
  const auto selectors = [](const std::string& json) {
    return value_of<NodeSelection>("where", json).selectors;
  };
  EXPECT_EQ(selectors(R"({"centre": [0.5, 1], "radius": 0})")[0].centre, Vec2(0.5, 1));
  EXPECT_EQ(selectors(R"({"box": [[0, 1], [2, 3]]})")[0].upper, Vec2(2, 3));
  EXPECT_THAT(selectors(R"({"boundary": ["left", "top"]})")[0].names, ElementsAre("left", "top"));
  EXPECT_THAT(selectors(R"({"corners": "all"})")[0].names, ElementsAre("all"));
  EXPECT_THAT(selectors(R"({"node": 3})")[0].numbers, ElementsAre(3));
  const auto both = selectors(R"([{"node": [3, 4]}, {"boundary": "left"}])");
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[0].form, NodeSelector::Form::node);
  EXPECT_EQ(both[1].form, NodeSelector::Form::boundary);
}

TEST(SceneValues, RejectsSelections) {
  EXPECT_THAT(complaint("where", "[]"), HasSubstr("where: found [], expected {\"centre\""));
  EXPECT_THAT(complaint("where", "\"all\""), HasSubstr("where: found \"all\", expected"));
  EXPECT_THAT(complaint("where", R"({"bundary": "all"})"), HasSubstr("expected {\"centre\""));
  EXPECT_THAT(complaint("where", R"({"centre": [0, 0]})"),
              HasSubstr("a \"radius\" with the other"));
  EXPECT_THAT(complaint("where", R"({"centre": [0, 0], "radius": -1})"),
              HasSubstr("where/radius: found -1, expected number >= 0 [m]"));
  EXPECT_THAT(complaint("where", R"({"box": [[0, 0], [1, -1]]})"), HasSubstr("a2 <= b2"));
  EXPECT_THAT(complaint("where", R"({"node": -1})"), HasSubstr("where/node: found -1"));
  EXPECT_THAT(complaint("where", R"({"node": []})"), HasSubstr("a node's number or a list"));
  EXPECT_THAT(complaint("where", R"([{"node": 1}, {"node": 0.5}])"), HasSubstr("where/1/node: "));
  EXPECT_THAT(complaint("where", R"({"node": 1, "boundary": "all"})"),
              HasSubstr("where/node: this selector has no \"node\"; valid is \"boundary\""));
}

TEST(SceneValues, ReadsNestedPlugins) {
  EXPECT_EQ(value_of<PluginUse>("normal", "\"exact\"").name, "exact");
  EXPECT_EQ(value_of<PluginUse>("shape", R"({"plugin": "flat"})").kind, PluginKind::shape);
  EXPECT_THAT(complaint("normal", "\"flat\""),
              AllOf(testing::StartsWith("normal: there is no normal plugin \"flat\""),
                    HasSubstr("there is a plugin shape/flat")));
  EXPECT_THAT(complaint("normal", R"({"plugin": "gauss", "delta": -1})"),
              HasSubstr("normal/delta: found -1, expected number >= 0"));
  EXPECT_THAT(complaint("normal", R"({"plugin": "broken_api"})"),
              HasSubstr("plugin API number is"));
}

TEST(SceneValues, FilesStartFromTheScenesFolder) {
  using Path = std::filesystem::path;
  EXPECT_EQ(value_of<Path>("file", "\"../a.obj\""), "/a.obj");
  EXPECT_EQ(value_of<Path>("file", "\"/b.obj\""), "/b.obj");
  const Scene scene = read(with_parameters("\"text\": \"\""));
  EXPECT_EQ(scene.plugins[PluginKind::force][0].parameters->get<Path>("file"),
            "/scenes/data/file.txt");
  EXPECT_EQ(scene.plugins[PluginKind::force][0].parameters->get<Path>("no_file"), "");
}

TEST(SceneValues, DefaultsThatNobodyCanSayStayUnsaid) {
  const Json force = Json::parse(read(with_parameters("\"flag\": true")).completed)["forces"][0];
  EXPECT_FALSE(force.contains("unsaid"));
  EXPECT_FALSE(force.contains("where"));
  EXPECT_FALSE(force.contains("shape"));
  EXPECT_EQ(force["limit"], "infinity");
  EXPECT_TRUE(force["normal"].contains("delta"));
}

TEST(JsonPointer, SplitsAndJoins) {
  EXPECT_THAT(*pointer_steps("/a~1b/~0/0/"), ElementsAre("a/b", "~", "0", ""));
  EXPECT_THAT(*pointer_steps(""), IsEmpty());
  EXPECT_FALSE(pointer_steps("a").has_value());
  EXPECT_FALSE(pointer_steps("/~2").has_value());
  EXPECT_FALSE(pointer_steps("/~").has_value());
  EXPECT_EQ(child_pointer("/x", "a/~b"), "/x/a~1~0b");
  EXPECT_EQ(parent_pointer("/x/a~1b"), "/x");
  EXPECT_EQ(parent_pointer("/x"), "");
  EXPECT_TRUE(is_within("/a/b", "/a"));
  EXPECT_FALSE(is_within("/ab", "/a"));
}

}  // namespace
}  // namespace deform
