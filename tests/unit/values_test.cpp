#include "deform/plugin/values.h"

#include <gtest/gtest.h>

#include "deform/error.h"
#include "deform/model/constraint.h"
#include "deform/plugin/plugin.h"
#include "deform/plugin/setup.h"

namespace deform {
namespace {

using Form = TimeProfile::Form;

TEST(TimeProfile, IsOneUnlessSaidOtherwise) {
  EXPECT_EQ(TimeProfile{}(-1), 1);
  EXPECT_EQ(TimeProfile{}(1e9), 1);
  EXPECT_EQ((TimeProfile{Form::constant, {{0, 0.25}}}(7)), 0.25);
}

TEST(TimeProfile, RampRisesBetweenItsTimes) {
  const TimeProfile ramp{Form::ramp, {{1, 0}, {3, 0}}};  // Factors do not matter.
  EXPECT_EQ(ramp(0), 0);
  EXPECT_EQ(ramp(1), 0);
  EXPECT_DOUBLE_EQ(ramp(1.5), 0.25);
  EXPECT_EQ(ramp(3), 1);
  EXPECT_EQ(ramp(10), 1);
}

TEST(TimeProfile, PulseLastsUntilJustBeforeItsEnd) {
  const TimeProfile pulse{Form::pulse, {{1, 0}, {3, 0}}};
  EXPECT_EQ(pulse(0.999), 0);
  EXPECT_EQ(pulse(1), 1);
  EXPECT_EQ(pulse(2.999), 1);
  EXPECT_EQ(pulse(3), 0);
}

TEST(TimeProfile, TableIsLinearBetweenPointsAndConstantOutside) {
  const TimeProfile table{Form::table, {{0, 1}, {1, 3}, {3, -1}}};
  EXPECT_EQ(table(-5), 1);
  EXPECT_DOUBLE_EQ(table(0.5), 2);
  EXPECT_DOUBLE_EQ(table(1), 3);
  EXPECT_DOUBLE_EQ(table(2), 1);
  EXPECT_EQ(table(4), -1);
  EXPECT_EQ((TimeProfile{Form::table, {{2, 0.5}}}(0)), 0.5);
}

TEST(TimeProfile, NamesItsBreaksInAnyUnitOfTime) {
  EXPECT_EQ(TimeProfile{}.next_break(0), kInfinity);
  EXPECT_EQ((TimeProfile{Form::constant, {{0, 2}}}.next_break(-1)), kInfinity);
  for (const double unit : {1e-12, 1.0, 1e9}) {
    const TimeProfile pulse{Form::pulse, {{2.3 * unit, 0}, {2.4 * unit, 0}}};
    EXPECT_EQ(pulse.next_break(0), 2.3 * unit);
    EXPECT_EQ(pulse.next_break(2.3 * unit), 2.4 * unit);
    EXPECT_EQ(pulse.next_break(2.4 * unit), kInfinity);
    EXPECT_DOUBLE_EQ(pulse.until_next_point(0), 2.3 * unit);
    EXPECT_NEAR(pulse.until_next_point(2.3 * (1 - 1e-15) * unit), 0.1 * unit, 1e-12 * unit);
  }
  EXPECT_EQ(first_after({1, 2, 4}, 2), 4);
}

TEST(Memory, ReturnsWhatWasPut) {
  Memory memory;
  memory.put("q", {1, 2});
  EXPECT_EQ(memory.get("q", 2), (std::vector<double>{1, 2}));
  EXPECT_THROW((void)memory.get("q", 3), InputError);
  EXPECT_THROW((void)memory.get("p", 2), InputError);
}

TEST(Reduction, LeavesFreeNodes) {
  Reduction reduction(3);
  reduction.prescribe(1, 2);
  reduction.prescribe(1, 2);
  EXPECT_TRUE(reduction.prescribed(1, 2));
  EXPECT_FALSE(reduction.prescribed(1, 0));
  EXPECT_EQ(reduction.free_nodes(2), (std::vector<Index>{0, 2}));
  EXPECT_EQ(reduction.free_nodes(0), (std::vector<Index>{0, 1, 2}));
  EXPECT_THROW(reduction.prescribe(3, 0), Error);
  EXPECT_THROW(reduction.prescribe(0, 3), Error);
}

TEST(Setup, ResolvesFilesFromItsFolder) {
  deform::Setup setup(nullptr);
  setup.with_folder("/scenes/paper");
  EXPECT_EQ(setup.resolve("../a.obj"), "/scenes/a.obj");
  EXPECT_EQ(setup.resolve("/b.obj"), "/b.obj");
}

TEST(Setup, RefusesWhatIsNotThereYet) {
  const deform::Setup setup(nullptr);
  EXPECT_THROW((void)setup.surface(), Error);
  EXPECT_THROW((void)setup.rest(), Error);
  EXPECT_THROW((void)setup.create<Constraint>({PluginKind::constraint, "pin", nullptr, ""}), Error);
}

TEST(InputError, SaysEveryProblemOnALine) {
  const InputError error({{"/a", "first"}, {"", "second"}});
  EXPECT_STREQ(error.what(), "first\nsecond");
  EXPECT_EQ(error.code(), ExitCode::bad_input);
}

}  // namespace
}  // namespace deform
