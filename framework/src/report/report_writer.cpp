#include "report/report_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "deform/compare/plan.h"
#include "deform/error.h"
#include "deform/log.h"
#include "deform/version.h"

#include "compare/triangles.h"
#include "report/base64.h"
#include "report/json_text.h"
#include "report/levels.h"
#include "report/shown_mesh.h"
#include "report/shown_moments.h"
#include "report/thinning.h"
#include "report/variant_frames.h"

namespace deform {
namespace {

using Scale = TrajectoryField::Scale;

constexpr int kFormat = 1;
/// Significant digits of a figure in a plot.
constexpr int kDigits = 8;
/// Moments that no other variant has are left out; with fewer than these the page is no film.
constexpr std::size_t kFewMoments = 2;

const char* name_of(Scale scale) {
  constexpr std::array kNames{"sequential", "diverging", "categorical"};
  return kNames[static_cast<std::size_t>(scale)];
}

/// The name under which a report has a field: one name has one unit and scale in all variants, so
/// that one that another has with other labels gets a name of its own.
class FieldNames {
 public:
  std::string name(const TrajectoryField& field, const std::string& variant) {
    const auto [known, is_new] = known_.try_emplace(field.name, field);
    if (is_new) names_.push_back(field.name);
    if (is_new || same(known->second, field)) return field.name;
    std::string own = fmt::format("{} ({})", field.name, variant);
    if (known_.try_emplace(own, field).second) names_.push_back(own);
    return own;
  }
  [[nodiscard]] std::size_t number(const std::string& name) const {
    return static_cast<std::size_t>(std::ranges::find(names_, name) - names_.begin());
  }
  [[nodiscard]] const std::vector<std::string>& all() const { return names_; }

 private:
  static bool same(const TrajectoryField& a, const TrajectoryField& b) {
    return a.unit == b.unit && a.scale == b.scale && a.labels == b.labels;
  }
  std::map<std::string, TrajectoryField> known_;
  std::vector<std::string> names_;
};

class ReportWriter {
 public:
  ReportWriter(std::string& text, const ReportSource& source, std::size_t most_bytes)
      : json_(text), text_(text), source_(source), most_bytes_(most_bytes), notes_(source.notes) {}
  void write();

 private:
  void choose_mesh();
  void choose_moments();
  void thin();
  void note_thinning(std::size_t all_nodes);
  void write_mesh();
  void write_frames();
  void write_variants();
  void write_variant(const ReportVariant& variant, std::optional<VariantFrames>& frames);
  void write_positions(std::optional<VariantFrames>& frames);
  void write_fields(const ReportVariant& variant, std::optional<VariantFrames>& frames);
  void write_field(const VariantFrames& frames, std::size_t field, const std::string& name);
  void write_probes(const FigureTable& table);
  std::optional<VariantFrames> open_frames(std::size_t variant);
  [[nodiscard]] std::size_t figures() const;
  template <class T>
  void write_base64(std::string_view key, std::span<const T> numbers) {
    json_.key(key);
    json_.text([numbers](std::string& text) {
      Base64Writer base64(text);
      base64.append(numbers);
      base64.finish();
    });
  }

  JsonText json_;
  std::string& text_;
  const ReportSource& source_;
  std::size_t most_bytes_;
  std::vector<std::string> notes_;
  TrajectoryMesh mesh_;
  ShownMesh shown_;
  ShownMoments moments_;
  FieldNames names_;
  Thinning thinning_;
  std::size_t probe_stride_ = 1;
  std::vector<std::string> mapped_;  // names of the variants on other meshes
};

bool is_refined(const ReportVariant& variant) { return variant.name == kRefined; }

void ReportWriter::write() {
  choose_mesh();
  choose_moments();
  thin();
  json_.begin('{');
  json_.member("format", kFormat);
  json_.member("kind", source_.kind);
  json_.member("title", source_.title);
  json_.member("created", source_.created);
  json_.member("program", fmt::format("deform {}", version()));
  write_mesh();
  write_frames();
  json_.member("reference", source_.reference);
  json_.member("tolerance", source_.tolerance);
  write_variants();
  json_.member("verdict", source_.verdict);
  json_.member("scene", source_.scene);
  if (!mapped_.empty()) {
    notes_.push_back(fmt::format("{}: computed on other nodes, drawn at those of the others",
                                 fmt::join(mapped_, ", ")));
  }
  json_.member("notes", notes_);
  json_.end('}');
}

/// That of the first variant that has one and is not a refined scene: most others share it.
void ReportWriter::choose_mesh() {
  const ReportVariant* chosen = nullptr;
  for (const ReportVariant& variant : source_.variants) {
    if (variant.moments.empty()) continue;
    if (chosen == nullptr || (is_refined(*chosen) && !is_refined(variant))) chosen = &variant;
  }
  if (chosen != nullptr) mesh_ = Trajectory(chosen->folder / kTrajectoryFile).mesh();
}

void ReportWriter::choose_moments() {
  std::vector<std::vector<Moment>> moments;
  std::size_t refined = source_.variants.size();
  for (const ReportVariant& variant : source_.variants) {
    if (is_refined(variant)) refined = moments.size();
    moments.push_back(variant.moments);
  }
  moments_ = shown_moments(moments, refined);
  const std::size_t common = moments_.moments.size();
  if (common < moments_.recorded && (common < kFewMoments || 2 * common < moments_.recorded)) {
    notes_.push_back(fmt::format(
        "{} of {} recorded moments are shown: those that all variants have; the same time between "
        "frames (/frames/every) gives more",
        common, moments_.recorded));
  }
}

std::size_t ReportWriter::figures() const {
  std::size_t figures = 0;
  for (const ReportVariant& variant : source_.variants)
    figures += variant.probe_rows * variant.probe_columns;
  return figures;
}

void ReportWriter::thin() {
  const auto lattice = ParameterLattice::of(mesh_);
  const auto all_nodes = static_cast<std::size_t>(mesh_.areas.size());
  ReportExtent extent;
  extent.nodes = [&](std::size_t stride) { return lattice ? lattice->nodes(stride) : all_nodes; };
  extent.moments = moments_.moments.size();
  std::vector<std::vector<std::string>> names;
  for (const ReportVariant& variant : source_.variants) {
    names.emplace_back();
    for (const TrajectoryField& field : variant.fields)
      names.back().push_back(names_.name(field, variant.name));
  }
  for (std::size_t v = 0; v < names.size(); ++v) {
    extent.variants.push_back({.frames = moments_.frames[v].size()});
    for (const std::string& name : names[v])
      extent.variants.back().fields.push_back(names_.number(name));
  }
  extent.fields = names_.all().size();
  thinning_ = choose_thinning(extent, most_bytes_);
  shown_ =
      lattice && thinning_.node_stride > 1 ? lattice->every(thinning_.node_stride) : whole(mesh_);
  note_thinning(all_nodes);
  moments_ = every(thinning_.frame_stride, moments_);
  probe_stride_ = std::max<std::size_t>(1, (figures() + kMostFigures - 1) / kMostFigures);
  if (probe_stride_ > 1)
    notes_.push_back(fmt::format("plots: every {}th row of probes.csv", probe_stride_));
}

void ReportWriter::note_thinning(std::size_t all_nodes) {
  const auto ordinal = [](std::size_t n) {
    return n == 2 ? std::string("2nd") : n == 3 ? "3rd" : fmt::format("{}th", n);
  };
  if (!shown_.is_whole) {
    notes_.push_back(fmt::format("shown: every {} node along each side, {} of {}",
                                 ordinal(thinning_.node_stride), shown_.numbers.size(), all_nodes));
  }
  if (thinning_.frame_stride > 1) {
    notes_.push_back(fmt::format("shown: every {} of {} recorded moments",
                                 ordinal(thinning_.frame_stride), moments_.moments.size()));
  }
  if (thinning_.fields < names_.all().size()) {
    const std::vector<std::string> lost(
        names_.all().begin() + static_cast<std::ptrdiff_t>(thinning_.fields), names_.all().end());
    notes_.push_back(fmt::format("not shown, for want of room: {}", fmt::join(lost, "; ")));
  }
  if (thinning_.shapes < source_.variants.size()) {
    notes_.push_back(
        fmt::format("for want of room only the first {} variants have a shape", thinning_.shapes));
  }
  if (!mesh_.faces.nodes.empty()) {
    notes_.emplace_back(
        "positions and fields are rounded to 16 bits: positions by at most 8e-6 of the extent of "
        "each variant's movement");
  }
}

void ReportWriter::write_mesh() {
  json_.key("mesh");
  json_.begin('{');
  json_.member("nodes", shown_.numbers.size());
  const Faces& faces = shown_.faces;
  bool are_quads = faces.size() > 0;
  for (std::size_t f = 0; f + 1 < faces.begin.size(); ++f)
    are_quads = are_quads && faces.begin[f + 1] - faces.begin[f] == 4;
  if (are_quads) {
    write_base64("quads", std::span<const std::int32_t>(faces.nodes));
  } else {
    std::vector<std::int32_t> corners;
    for (const Triangle& triangle : triangles_of(faces))
      corners.insert(corners.end(), triangle.begin(), triangle.end());
    write_base64("triangles", std::span<const std::int32_t>(corners));
  }
  std::vector<float> parameters;
  for (Index k = 0; k < shown_.parameters.rows(); ++k) {
    parameters.push_back(static_cast<float>(shown_.parameters(k, 0)));
    parameters.push_back(static_cast<float>(shown_.parameters(k, 1)));
  }
  write_base64("parameters", std::span<const float>(parameters));
  if (!shown_.is_whole) write_base64("numbers", std::span<const std::int32_t>(shown_.numbers));
  json_.end('}');
}

void ReportWriter::write_frames() {
  Json steps = Json::array(), times = Json::array();
  for (const Moment& moment : moments_.moments) {
    steps.push_back(moment.step);
    times.push_back(moment.time);
  }
  json_.member("frames", {{"steps", steps}, {"times", times}});
}

std::optional<VariantFrames> ReportWriter::open_frames(std::size_t v) {
  if (v >= thinning_.shapes || moments_.frames[v].empty()) return std::nullopt;
  const ReportVariant& variant = source_.variants[v];
  try {
    std::optional<VariantFrames> frames;
    frames.emplace(variant.folder / kTrajectoryFile, mesh_, shown_, moments_.frames[v]);
    if (frames->is_mapped()) mapped_.push_back(variant.name);
    return frames;
  } catch (const InputError& e) {
    notes_.push_back(fmt::format("{} has no shape: {}", variant.name, e.what()));
    log::warn(notes_.back());
    return std::nullopt;
  }
}

void ReportWriter::write_variants() {
  json_.key("variants");
  json_.begin('[');
  for (std::size_t v = 0; v < source_.variants.size(); ++v) {
    auto frames = open_frames(v);
    write_variant(source_.variants[v], frames);
  }
  json_.end(']');
}

/// What a run's manifest says of its cost; steps that another process did were not timed by it.
Json cost_of(const Json& manifest) {
  const auto figure = [](const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_number() ? found->get<double>() : std::nan("");
  };
  if (!manifest.is_object()) return nullptr;
  const auto seconds = manifest.find("seconds");
  const double total = seconds != manifest.end() ? figure(*seconds, "all_steps") : std::nan("");
  const double steps = figure(manifest, "steps_timed");
  const double ms = steps > 0 ? 1e3 * total / steps : std::nan("");
  return {{"ms_per_step", ms},
          {"peak_memory_MB", figure(manifest, "peak_memory_MB")},
          {"iterations", nullptr}};
}

void ReportWriter::write_variant(const ReportVariant& variant,
                                 std::optional<VariantFrames>& frames) {
  std::vector<std::string> said_before;  // read_report_source has noted it
  RecordedRun run;
  if (!variant.folder.empty()) run = read_variant(variant.folder, said_before);
  if (!variant.has_probes) run.probes = {};
  json_.begin('{');
  json_.member("name", variant.name);
  json_.member("status", variant.status);
  json_.member("reason", variant.reason);
  json_.member("frames", frames ? frames->size() : 0);
  write_positions(frames);
  write_fields(variant, frames);
  write_probes(run.probes);
  json_.member("changes", variant.changes);
  json_.member("dropped", variant.dropped);
  json_.member("cost", cost_of(run.manifest));
  json_.member("parts", variant.parts);
  json_.member("not_measured", variant.not_measured);
  json_.member("manifest", run.manifest);
  json_.end('}');
}

void ReportWriter::write_positions(std::optional<VariantFrames>& frames) {
  std::array<LevelRange, 3> ranges;
  const std::size_t count = frames ? frames->size() : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const NodeVectors r = frames->positions(i);
    for (Index c = 0; c < 3; ++c) {
      const auto x = r.col(c);
      ranges[static_cast<std::size_t>(c)].add(x.minCoeff());
      ranges[static_cast<std::size_t>(c)].add(x.maxCoeff());
    }
  }
  json_.key("positions");
  json_.begin('{');
  json_.member("min", {ranges[0].min(), ranges[1].min(), ranges[2].min()});
  json_.member("max", {ranges[0].max(), ranges[1].max(), ranges[2].max()});
  json_.key("data");
  json_.text([&](std::string& text) {
    Base64Writer base64(text);
    std::vector<std::uint16_t> levels;
    for (std::size_t i = 0; i < count; ++i) {
      const NodeVectors r = frames->positions(i);
      levels.clear();
      for (Index k = 0; k < r.rows(); ++k) {
        for (std::size_t c = 0; c < 3; ++c)
          levels.push_back(ranges[c].level(r(k, static_cast<Index>(c))));
      }
      base64.append(std::span<const std::uint16_t>(levels));
    }
    base64.finish();
  });
  json_.end('}');
}

void ReportWriter::write_fields(const ReportVariant& variant,
                                std::optional<VariantFrames>& frames) {
  json_.key("fields");
  json_.begin('[');
  for (std::size_t f = 0; frames && f < frames->fields().size(); ++f) {
    const std::string name = names_.name(frames->fields()[f], variant.name);
    if (names_.number(name) < thinning_.fields) write_field(*frames, f, name);
  }
  json_.end(']');
}

void ReportWriter::write_field(const VariantFrames& frames, std::size_t f,
                               const std::string& name) {
  const TrajectoryField& field = frames.fields()[f];
  const bool is_category = field.scale == Scale::categorical;
  LevelRange range;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    for (const float value : frames.field(i, f)) range.add(static_cast<double>(value));
  }
  json_.begin('{');
  json_.member("name", name);
  json_.member("unit", field.unit);
  json_.member("scale", name_of(field.scale));
  if (is_category) json_.member("labels", field.labels);
  json_.member("min", range.min());
  json_.member("max", range.max());
  json_.key("data");
  json_.text([&](std::string& text) {
    Base64Writer base64(text);
    std::vector<std::uint16_t> levels;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      levels.clear();
      for (const float number : frames.field(i, f)) {
        const auto value = static_cast<double>(number);
        levels.push_back(is_category ? level_of_category(value) : range.level(value));
      }
      base64.append(std::span<const std::uint16_t>(levels));
    }
    base64.finish();
  });
  json_.end('}');
}

/// A number as short as a plot needs it.
std::string short_number(double figure) {
  return std::isfinite(figure) ? fmt::format("{:.{}g}", figure, kDigits) : "null";
}

void ReportWriter::write_probes(const FigureTable& table) {
  Json columns = {{{"name", "step"}, {"unit", ""}}, {{"name", "time"}, {"unit", "s"}}};
  for (std::size_t c = 0; c < table.names.size(); ++c)
    columns.push_back({{"name", table.names[c]}, {"unit", table.units[c]}});
  json_.key("probes");
  json_.begin('{');
  json_.member("columns", columns);
  json_.key("rows");
  json_.begin('[');
  for (const std::size_t row : every(probe_stride_, table.moments.size())) {
    json_.raw([&](std::string& text) {
      text += fmt::format("[{},{}", table.moments[row].step, short_number(table.moments[row].time));
      for (const double figure : table.figures[row]) text += ',' + short_number(figure);
      text += ']';
    });
  }
  json_.end(']');
  json_.end('}');
}

}  // namespace

void append_report(std::string& text, const ReportSource& source, std::size_t most_bytes) {
  ReportWriter(text, source, most_bytes).write();
}

}  // namespace deform
