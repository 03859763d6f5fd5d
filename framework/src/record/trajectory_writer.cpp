#include "record/trajectory_writer.h"

#include <span>
#include <vector>

#include "record/trajectory_format.h"

namespace deform {
namespace {

using namespace trajectory_format;

template <class T>
void append(std::string& bytes, std::span<const T> values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
}

template <class T>
void append(std::string& bytes, const T& value) {
  append(bytes, std::span<const T>(&value, 1));
}

template <class Matrix>
void append_matrix(std::string& bytes, const Matrix& m) {
  append(bytes, std::span<const double>(m.data(), static_cast<std::size_t>(m.size())));
}

}  // namespace

TrajectoryWriter::TrajectoryWriter(const std::filesystem::path& file, const System& system,
                                   double size, std::size_t keep)
    : fields_(system), file_(file, keep) {
  if (keep == 0) file_.append(header(system, size));
}

std::string TrajectoryWriter::header(const System& system, double size) const {
  const Surface& surface = system.surface();
  const Faces& faces = surface.faces();
  Json json = {{"nodes", surface.nodes()},
               {"faces", faces.size()},
               {"corners", faces.nodes.size()},
               {"size", size},
               {"fields", Json::array()}};
  for (const TrajectoryField& field : fields_.fields()) json["fields"].push_back(json_of(field));
  if (!system.scalars().empty()) json["scalars"] = system.scalars().size();
  const std::string text = json.dump();
  std::string bytes(kMagic);
  append(bytes, static_cast<std::uint64_t>(text.size()));
  bytes += text;
  append_matrix(bytes, surface.parameters());
  append_matrix(bytes, system.areas());
  append(bytes, std::span<const std::int32_t>(faces.begin));
  append(bytes, std::span<const std::int32_t>(faces.nodes));
  return bytes;
}

void TrajectoryWriter::record(const Frame& frame) {
  if (frame.step == last_) return;
  frame_.clear();
  append(frame_, static_cast<std::int64_t>(frame.step));
  append(frame_, frame.state.time);
  append_matrix(frame_, NodeVectors(frame.positions()));
  for (const std::vector<float>& values : fields_.evaluate(frame)) {
    append(frame_, std::span<const float>(values));
  }
  const Index nodes = frame.system.nodes();
  append_matrix(frame_, NodeValues(frame.state.r.col(0).tail(frame.state.r.rows() - nodes)));
  file_.append(frame_);
  last_ = frame.step;
}

WrittenFile TrajectoryWriter::sync() {
  file_.sync();
  return file_.written();
}

WrittenFile TrajectoryWriter::close() {
  file_.close();
  return file_.written();
}

}  // namespace deform
