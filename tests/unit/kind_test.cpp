#include "deform/plugin/kind.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "deform/error.h"
#include "deform/plugin/registry.h"
#include "deform/surface/shape.h"

#include "scene/scene_rules.h"
#include "support/builtin.h"

namespace deform {
namespace {

TEST(Kinds, AreKnownByTheirNames) {
  for (const PluginKind kind : kPluginKinds) EXPECT_EQ(kind_named(name_of(kind)), kind);
  EXPECT_EQ(kind_named("colour"), std::nullopt);
  EXPECT_EQ(kind_named("energies"), std::nullopt);
}

TEST(Kinds, HaveTheSameOrderInEveryTable) {
  EXPECT_EQ(name_of(PluginKind::energy), "energy");
  EXPECT_EQ(plural_of(PluginKind::energy), "energies");
  const auto kinds = per_kind<PluginKind>([]<class Interface>() {
    return std::is_same_v<Interface, Shape> ? PluginKind::shape : PluginKind::surface;
  });
  for (const PluginKind kind : kPluginKinds)
    EXPECT_EQ(kinds[kind] == PluginKind::shape, kind == PluginKind::shape);
}

TEST(Kinds, StandInScenesByNameOrPlural) {
  for (const PluginKind kind : kPluginKinds) {
    const SceneSection* const section = section_of(kind);
    if (section == nullptr) continue;  // in parameters alone
    const bool is_list = section->form == SceneSection::Form::plugins;
    EXPECT_EQ(section->name, is_list ? plural_of(kind) : name_of(kind));
  }
  EXPECT_EQ(section_of(PluginKind::shape), nullptr);
  EXPECT_EQ(section_of(PluginKind::normal), nullptr);  // shadows take no part in a run
}

TEST(SceneSections, OfOneValueHaveTheNameOfItsField) {
  for (const SceneSection& section : scene_sections()) {
    if (section.form != SceneSection::Form::value) continue;
    EXPECT_EQ(section.name, section.fields().front().name);
  }
}

TEST(Kinds, AreAskedForByTheirInterface) {
  const PluginRegistry registry;
  const PluginUse normal{PluginKind::normal, "exact", nullptr, "/surface/rest"};
  try {
    (void)registry.create<Shape>(normal, test::bare_setup());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "plugin 'exact' is of another kind");
    EXPECT_EQ(error.problems().front().pointer, "/surface/rest");
  }
}

}  // namespace
}  // namespace deform
