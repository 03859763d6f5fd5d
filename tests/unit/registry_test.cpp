#include "deform/plugin/registry.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "deform/error.h"
#include "deform/model/normal_estimator.h"

#include "support/builtin.h"

namespace deform {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

const fs::path kFixtures = DEFORM_FIXTURE_PLUGINS;
const fs::path kBuiltins = DEFORM_PLUGINS;

/// What the InputError or PluginFailure says that f() throws.
template <class Expected, class F>
std::string message_of(F f) {
  try {
    (void)f();
  } catch (const Expected& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::string load_error(const std::string& name) {
  return message_of<InputError>(
      [&] { return load_plugin(kFixtures / ("normal-" + name + ".so")).origin(); });
}

std::string failure(const std::string& name) {
  const LoadedPlugin plugin = load_plugin(kFixtures / ("normal-" + name + ".so"));
  return message_of<PluginFailure>([&] { return plugin.create({}, test::bare_setup()); });
}

TEST(LoadPlugin, ChecksTheAbiTag) {
  const AbiTag tag = abi_tag();
  EXPECT_THAT(load_error("broken_size"),
              AllOf(HasSubstr((kFixtures / "normal-broken_size.so").string()),
                    HasSubstr("size of the ABI tag is " + std::to_string(tag.size + 8) +
                              ", expected " + std::to_string(tag.size))));
  EXPECT_THAT(load_error("broken_api"),
              HasSubstr("plugin API number is " + std::to_string(tag.api + 1) + ", expected " +
                        std::to_string(tag.api)));
  EXPECT_THAT(load_error("broken_compiler"),
              AllOf(HasSubstr("compiler is \"x"), HasSubstr("standard library is \"x"),
                    HasSubstr(std::string(", expected \"") + tag.compiler + '"')));
  EXPECT_THAT(load_error("broken_flavour"), HasSubstr("build flavour is \"x"));
  EXPECT_THAT(load_error("broken_eigen"), HasSubstr("Eigen version is"));
  EXPECT_THAT(load_error("broken_alignment"),
              HasSubstr("EIGEN_MAX_ALIGN_BYTES is " + std::to_string(2 * tag.eigen_max_align)));
}

TEST(LoadPlugin, ChecksWhatTheLibrarySaysOfItself) {
  EXPECT_THAT(load_error("broken_symbol"), HasSubstr(kDescriptorSymbol));
  EXPECT_THAT(load_error("broken_kind"), HasSubstr("must be named energy-broken_kind.so"));
  EXPECT_THAT(load_error("broken_name"), HasSubstr("must be named normal-another.so"));
  EXPECT_THAT(load_error("broken_parameters"), HasSubstr("declares the parameter \"plugin\""));
  EXPECT_THAT(load_error("broken_declaration"), HasSubstr("no parameters today"));
}

TEST(LoadPlugin, RejectsWhatIsNoLibrary) {
  const fs::path folder = fs::path(testing::TempDir()) / "load_plugin_test";
  fs::create_directories(folder);
  std::ofstream(folder / "normal-text.so") << "no library";
  const auto error = [](const fs::path& path) {
    return message_of<InputError>([&] { return load_plugin(path).origin(); });
  };
  EXPECT_THAT(error(folder / "normal-text.so"), HasSubstr("cannot be loaded"));
  EXPECT_THAT(error(folder / "normal-none.so"), HasSubstr("no such file"));
  EXPECT_THAT(error(folder / "text.so"), HasSubstr("KIND-NAME.so"));
  EXPECT_THAT(error(folder / "colour-text.so"), HasSubstr("KIND-NAME.so"));
  fs::remove_all(folder);
}

TEST(LoadedPlugin, ReportsWhateverAConstructorThrows) {
  EXPECT_THAT(failure("throws_std"), AllOf(HasSubstr("normal/throws_std ("), HasSubstr(".so)"),
                                           HasSubstr("out of ideas")));
  EXPECT_THAT(failure("throws_int"), AllOf(HasSubstr("normal/throws_int ("), HasSubstr("int")));
}

TEST(LoadedPlugin, ReportsObjectsOfAnotherKind) {
  EXPECT_THAT(failure("broken_interface"), HasSubstr("no normal plugin"));
  EXPECT_THAT(failure("broken_null"), HasSubstr("no normal plugin"));
}

TEST(LoadedPlugin, ObjectsKeepTheirLibraryLoaded) {
  std::shared_ptr<Plugin> object;
  {
    const LoadedPlugin plugin = load_plugin(kBuiltins / "normal-exact.so");
    object = plugin.create({}, test::bare_setup());
  }
  const auto normal = std::dynamic_pointer_cast<NormalEstimator>(object);
  ASSERT_NE(normal, nullptr);
  Memory memory;
  normal->save(memory);  // Would crash without its code.
  EXPECT_TRUE(memory.entries().empty());
}

class Registry : public testing::Test {
 protected:
  void SetUp() override {
    const auto* const test = testing::UnitTest::GetInstance()->current_test_info();
    folder_ = fs::path(testing::TempDir()) / (std::string("registry_") + test->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    fs::permissions(folder_, fs::perms::owner_all);
    unsetenv("DEFORM_PLUGIN_PATH");
  }
  void TearDown() override {
    unsetenv("DEFORM_PLUGIN_PATH");
    fs::remove_all(folder_);
  }

  static void set_path(const std::string& path) { setenv("DEFORM_PLUGIN_PATH", path.c_str(), 1); }

  /// Folders besides the installation's, and who named them.
  static std::vector<std::string> folders(const PluginRegistry& registry) {
    std::vector<std::string> text;
    for (const SearchFolder& f : registry.folders()) {
      if (f.said_by != "installation") text.push_back(f.said_by + " " + f.path.string());
    }
    return text;
  }

  static std::string path_error(const std::string& path) {
    set_path(path);
    return message_of<InputError>([] { return PluginRegistry().folders(); });
  }

  fs::path folder_;
};

TEST_F(Registry, FindsTheInstallationsPlugins) {
  const PluginRegistry registry;
  ASSERT_EQ(registry.folders().size(), 1U);
  EXPECT_EQ(registry.folders().front().path, kBuiltins);
  EXPECT_THAT(registry.names(PluginKind::normal), testing::IsSupersetOf({"exact", "gauss"}));
}

TEST_F(Registry, LoadsOnce) {
  const PluginRegistry registry;
  const LoadedPlugin& exact = registry.load(PluginKind::normal, "exact");
  EXPECT_EQ(&registry.load(PluginKind::normal, "exact"), &exact);
  EXPECT_EQ(exact.file().path, kBuiltins / "normal-exact.so");
}

TEST_F(Registry, SearchesEachFolderOnce) {
  const fs::path link = folder_ / "link";
  fs::create_directory_symlink(kFixtures, link);
  set_path(kFixtures.string() + "::" + folder_.string() + ":" + link.string());
  const PluginRegistry registry({kFixtures});
  EXPECT_EQ(folders(registry),
            (std::vector<std::string>{"--plugin-path " + kFixtures.string(),
                                      "DEFORM_PLUGIN_PATH " + folder_.string()}));
}

TEST_F(Registry, RefusesFoldersThatAreNone) {
  const auto error = message_of<InputError>([&] {
    return PluginRegistry({folder_ / "none", kFixtures / "normal-throws_int.so"}).files();
  });
  EXPECT_THAT(error, AllOf(HasSubstr("--plugin-path: the folder"), HasSubstr("does not exist"),
                           HasSubstr("is not a folder")));
}

TEST_F(Registry, RefusesUnsafeFoldersOfTheEnvironment) {
  EXPECT_THAT(path_error("plugins"), HasSubstr("DEFORM_PLUGIN_PATH: the folder plugins is not an "
                                               "absolute path"));
  EXPECT_THAT(path_error((folder_ / "none").string()), HasSubstr("does not exist"));
  fs::permissions(folder_, fs::perms::all);
  EXPECT_THAT(path_error(folder_.string()), HasSubstr("is world-writable"));
  EXPECT_EQ(path_error(kFixtures.string()), "nothing was thrown");
}

TEST_F(Registry, IgnoresOtherFiles) {
  std::ofstream(folder_ / "normal-.so") << "";
  std::ofstream(folder_ / "libnormal.so") << "";
  std::ofstream(folder_ / "normal-Upper.so") << "";
  std::ofstream(folder_ / "normal-fine.txt") << "";
  std::ofstream(folder_ / "normal-fine.so") << "";
  const PluginRegistry registry({folder_});
  std::vector<std::string> found;
  for (const PluginFile& file : registry.files()) {
    if (file.path.parent_path() == folder_) found.push_back(file.name);
  }
  EXPECT_EQ(found, std::vector<std::string>{"fine"});
}

TEST_F(Registry, SaysWhereItSearchedAndWhatIsNear) {
  const PluginRegistry registry({folder_});
  const auto error = [&](PluginKind kind, const char* name) {
    return message_of<InputError>([&] { return registry.load(kind, name).origin(); });
  };
  EXPECT_THAT(error(PluginKind::normal, "gaus"),
              AllOf(HasSubstr("no normal plugin \"gaus\"; did you mean \"gauss\"?"),
                    HasSubstr(folder_.string() + " (--plugin-path)"),
                    HasSubstr(kBuiltins.string() + " (installation)")));
  EXPECT_THAT(error(PluginKind::energy, "gauss"), HasSubstr("there is a plugin normal/gauss"));
}

TEST_F(Registry, TwoOfOneNameAreAnErrorWhenAskedFor) {
  fs::copy(kBuiltins / "normal-exact.so", folder_);
  const PluginRegistry registry({folder_});
  EXPECT_NO_THROW((void)registry.load(PluginKind::normal, "gauss"));
  EXPECT_THAT(
      message_of<InputError>([&] { return registry.load(PluginKind::normal, "exact").origin(); }),
      AllOf(HasSubstr("two normal plugins \"exact\""),
            HasSubstr((folder_ / "normal-exact.so").string()),
            HasSubstr((kBuiltins / "normal-exact.so").string())));
}

TEST_F(Registry, ProblemsGetThePointerOfTheUse) {
  const PluginRegistry registry({kFixtures});
  try {
    (void)registry.create({PluginKind::normal, "throws_input", nullptr, "/energies/1/normal"},
                          test::bare_setup());
    FAIL();
  } catch (const InputError& error) {
    ASSERT_EQ(error.problems().size(), 2U);
    EXPECT_EQ(error.problems()[0].pointer, "/energies/1/normal/delta");
    EXPECT_EQ(error.problems()[0].message, "at /energies/1/normal/delta: found 1, expected 2");
    EXPECT_EQ(error.problems()[1].message, "at /energies/1/normal: nothing fits");
  }
}

TEST_F(Registry, ProblemsOfInnerPluginsKeepTheirPointer) {
  const PluginRegistry registry({kFixtures});
  const deform::Setup setup([&](const PluginUse& use, const deform::Setup& inner) {
    return registry.create(use, inner);
  });
  ParameterValues values;
  values.set("normal",
             PluginUse{PluginKind::normal, "throws_input", nullptr, "/energies/0/normal"});
  const PluginUse bending{PluginKind::energy, "bending",
                          std::make_shared<const ParameterValues>(values), "/energies/0"};
  EXPECT_THAT(message_of<InputError>([&] { return registry.create(bending, setup); }),
              testing::StartsWith("at /energies/0/normal/delta: found 1"));
}

TEST(ParameterSchema, DescribesEveryType) {
  const json schema = json::parse(parameter_schema(load_plugin(kFixtures / "force-every_type.so")));
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["required"], json::array({"plugin"}));
  const json& p = schema["properties"];
  EXPECT_EQ(p["plugin"]["const"], "every_type");
  EXPECT_EQ(p["number"], (json{{"type", "number"},
                               {"minimum", 0.0},
                               {"maximum", 1.0},
                               {"description", "a number [1/m]"},
                               {"default", 0.5}}));
  EXPECT_EQ(p["limit"]["anyOf"][1], (json{{"const", "infinity"}}));
  EXPECT_EQ(p["limit"]["anyOf"][0]["exclusiveMinimum"], 0);
  EXPECT_EQ(p["limit"]["default"], "infinity");
  EXPECT_EQ(p["small"]["maximum"], 2147483647);
  EXPECT_EQ(p["choice"]["enum"], json::array({"left", "right"}));
  EXPECT_EQ(p["vector"]["minItems"], 3);
  EXPECT_EQ(p["weights"]["default"], 0.1);
  EXPECT_FALSE(p["where"].contains("default"));
  EXPECT_FALSE(p["unsaid"].contains("default"));
  EXPECT_EQ(p["normal"]["default"]["plugin"], "gauss");
}

TEST(ParameterSchema, HasTheCommonFields) {
  const json schema =
      json::parse(parameter_schema(load_plugin(kBuiltins / "integrator-semi_implicit.so")));
  EXPECT_EQ(schema["properties"]["step"]["exclusiveMinimum"], 0);
  EXPECT_EQ(schema["required"][1], "step");
}

TEST(Describe, SaysParametersInWords) {
  const LoadedPlugin plugin = load_plugin(kFixtures / "force-every_type.so");
  const auto text = [&](const std::string& name) {
    for (const ParameterField& field : plugin.fields()) {
      if (field.name != name) continue;
      const ParameterText t = describe(field);
      return t.type + "|" + t.range + "|" + t.default_value;
    }
    return std::string();
  };
  EXPECT_EQ(text("number"), "number|>= 0, <= 1|0.5");
  EXPECT_EQ(text("limit"), "number|> 0, or \"infinity\"|\"infinity\"");
  EXPECT_EQ(text("choice"), "text|\"left\", \"right\"|\"left\"");
  EXPECT_EQ(text("normal"), "normal plugin||gauss");
  EXPECT_EQ(text("where"), "selection of nodes||");
  EXPECT_EQ(text("field"), "number, formula or map|> 0, <= 2|0.5");
  EXPECT_EQ(text("weights_field"),
            "number, formula or map, or [[11, 12], [21, 22]] of them|>= 0|0.1");
  EXPECT_EQ(text("named"), "object of numbers|<= 10|{\"k\":2.0}");
}

}  // namespace
}  // namespace deform
