#include "mesh_command.h"

#include <algorithm>
#include <memory>
#include <string>

#include "deform/error.h"
#include "deform/plugin/setup.h"
#include "deform/surface/summary.h"

#include "report_error.h"
#include "terminal.h"

namespace deform::app {
namespace {

std::shared_ptr<Surface> read(const std::filesystem::path& file, bool repair,
                              const PluginRegistry& registry) {
  ParameterValues values;
  values.set("path", file);
  values.set("repair", repair);
  const PluginUse use{.kind = PluginKind::surface,
                      .name = "mesh",
                      .parameters = std::make_shared<const ParameterValues>(values),
                      .pointer = ""};
  const Setup setup([&registry](const PluginUse& what, const Setup& with) {
    return registry.create(what, with);
  });
  try {
    return registry.create<Surface>(use, setup);
  } catch (const InputError& error) {  // there is no scene that pointers could be of
    std::vector<Problem> problems = error.problems();
    for (Problem& problem : problems) problem.pointer.clear();
    throw InputError(std::move(problems));
  }
}

const char* kind_of(const SurfaceSummary& s) {
  if (!s.borders.empty()) return "open";
  return s.euler_characteristic == 2   ? "closed, as a sphere"
         : s.euler_characteristic == 0 ? "closed, as a torus"
                                       : "closed";
}

void describe(const std::filesystem::path& file, const SurfaceSummary& s) {
  say("{}: {} vertices, {} edges, {} triangles (Euler characteristic {}), {}{}\n", file.string(),
      s.nodes, s.edges, s.faces, s.euler_characteristic, kind_of(s),
      s.has_chart ? ", in a plane: its coordinates are a1 and a2" : "");
  for (const SurfaceSummary::Border& border : s.borders)
    say("  {}: {} vertices\n", border.name, border.nodes);
  say("  extent     x {:.6g} … {:.6g}, y {:.6g} … {:.6g}, z {:.6g} … {:.6g} m\n", s.lower.x(),
      s.upper.x(), s.lower.y(), s.upper.y(), s.lower.z(), s.upper.z());
  say("  area       {:.6g} m²\n", s.area);
  say("  edges      {:.4g} … {:.4g} m, {:.4g} on average\n", s.edge.least, s.edge.largest,
      s.edge.mean);
  say("  angles     {:.3g}° at least, the least of a triangle {:.3g}° on average\n", s.angle.least,
      s.angle.mean);
  say("  curvature  |H| up to {:.4g} 1/m, K {:.4g} … {:.4g} 1/m²\n", s.mean_curvature.largest,
      s.gaussian_curvature.least, s.gaussian_curvature.largest);
}

}  // namespace

int describe_meshes(const std::vector<std::filesystem::path>& files, bool repair,
                    const PluginRegistry& registry) {
  int code = static_cast<int>(ExitCode::done);
  for (const std::filesystem::path& file : files) {
    try {
      describe(file, summary_of(*read(file, repair, registry)));
    } catch (...) {
      code = std::max(code, report_current_error());
    }
  }
  return code;
}

}  // namespace deform::app
