#include "deform/record/trajectory.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"

#include "json/json_file.h"
#include "record/trajectory_format.h"

namespace deform {

using namespace trajectory_format;

namespace {

/// To open a pipe may take for ever.
std::filesystem::path regular(std::filesystem::path file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (exists(status) && !is_regular_file(status))
    throw InputError(fmt::format("{} is not a trajectory: it is no regular file", file.string()));
  return file;
}

}  // namespace

Trajectory::Trajectory(std::filesystem::path file)
    : path_(regular(std::move(file))), file_(path_, std::ios::binary) {
  if (!file_) throw InputError(fmt::format("there is no trajectory '{}'", path_.string()));
  try {
    read_header();
    find_moments();
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError(fmt::format("{} is not a trajectory: {}", path_.string(), e.what()));
  }
}

void Trajectory::read_header() {
  bytes_ = std::filesystem::file_size(path_);
  std::string magic(kMagic.size(), '\0');
  read(0, magic.data(), magic.size());
  if (magic != kMagic) throw std::runtime_error("it does not begin like one of this version");
  std::uint64_t length = 0;
  read(kMagic.size(), &length, sizeof length);
  if (length > kMostHeader) throw std::runtime_error("its header is too long");
  std::string text(length, '\0');
  read(kMagic.size() + sizeof length, text.data(), length);
  const Json header = parse_json(text);
  if (!header.is_object()) throw std::runtime_error("its header is no JSON object");
  first_frame_ = kMagic.size() + sizeof length + length;
  const auto count = [&header](const char* key) {
    const Json& number = header.at(key);
    // What is not even as many bytes is too much, before anything is computed of it.
    if (!number.is_number_unsigned() ||
        number.get<std::uint64_t>() > std::numeric_limits<std::int32_t>::max())
      throw std::runtime_error(std::string("its number of ") + key + " is none");
    return number.get<std::size_t>();
  };
  mesh_.size = header.at("size").get<double>();
  if (!(mesh_.size > 0) || !std::isfinite(mesh_.size))
    throw std::runtime_error("its surface has no size");
  for (const Json& field : header.at("fields")) fields_.push_back(field_of(field));
  if (header.contains("scalars")) scalars_ = count("scalars");
  read_mesh(count("nodes"), count("faces"), count("corners"));
  check_mesh();
}

void Trajectory::read_mesh(std::size_t nodes, std::size_t faces, std::size_t corners) {
  if (first_frame_ + 24 * nodes + 4 * (faces + 1 + corners) > bytes_)
    throw std::runtime_error("it is cut off");
  mesh_.areas.resize(static_cast<Index>(nodes));
  mesh_.parameters.resize(mesh_.areas.size(), 2);
  mesh_.faces.begin.resize(faces + 1);
  mesh_.faces.nodes.resize(corners);
  const auto take = [this](auto* to, std::size_t count) {
    read(first_frame_, to, count * sizeof *to);
    first_frame_ += count * sizeof *to;
  };
  take(mesh_.parameters.data(), 2 * nodes);
  take(mesh_.areas.data(), nodes);
  take(mesh_.faces.begin.data(), faces + 1);
  take(mesh_.faces.nodes.data(), corners);
}

/// Readers go by the numbers of nodes and corners without looking at them again.
void Trajectory::check_mesh() const {
  const auto& begin = mesh_.faces.begin;
  const auto& corners = mesh_.faces.nodes;
  constexpr std::int32_t kLeastCorners = 3;
  bool are_faces = begin.front() == 0 && std::cmp_equal(begin.back(), corners.size());
  for (std::size_t f = 0; f + 1 < begin.size(); ++f) {
    // From 0 up: the difference does not overflow before it is found too small.
    are_faces = are_faces && begin[f + 1] >= begin[f] && begin[f + 1] - begin[f] >= kLeastCorners;
  }
  if (nodes() == 0) throw std::runtime_error("its surface has no nodes");
  if (!are_faces) throw std::runtime_error("its faces do not follow each other");
  const auto is_node = [this](std::int32_t node) {
    return node >= 0 && std::cmp_less(node, nodes());
  };
  if (!std::ranges::all_of(corners, is_node))
    throw std::runtime_error("a corner of a face is no node");
  if (!mesh_.parameters.allFinite() || !mesh_.areas.allFinite())
    throw std::runtime_error("its parameters or areas are not finite");
}

std::size_t Trajectory::frame_bytes() const {
  return bytes_of_frame(nodes(), fields_.size()) + scalars_ * sizeof(double);
}

void Trajectory::find_moments() {
  for (std::size_t at = first_frame_; at + frame_bytes() <= bytes_; at += frame_bytes()) {
    std::int64_t step = 0;
    double time = 0;
    read(at, &step, sizeof step);
    read(at + sizeof step, &time, sizeof time);
    const bool ascends =
        moments_.empty() || (step > moments_.back().step && time > moments_.back().time);
    if (step < 0 || !std::isfinite(time) || time < 0 || !ascends)
      throw std::runtime_error("its steps and times do not ascend");
    moments_.push_back({step, time});
  }
}

void Trajectory::read(std::size_t at, void* to, std::size_t bytes) const {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(at));
  file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
  if (!file_) throw std::runtime_error("it cannot be read, or is cut off");
}

std::size_t Trajectory::place_of(std::size_t frame) const {
  if (frame >= frames()) throw std::out_of_range("a trajectory has no such frame");
  return first_frame_ + frame * frame_bytes();
}

void Trajectory::read_finite(std::size_t frame, std::size_t offset, double* to, std::size_t count,
                             const char* what) const {
  try {
    read(place_of(frame) + offset, to, count * sizeof(double));
  } catch (const std::runtime_error& e) {
    throw InputError(fmt::format("{}: {}", path_.string(), e.what()));
  }
  if (!std::all_of(to, to + count, [](double x) { return std::isfinite(x); }))
    throw InputError(fmt::format("{} is damaged: a {} of its frame {} is not finite",
                                 path_.string(), what, frame));
}

NodeVectors Trajectory::positions(std::size_t frame) const {
  NodeVectors r(mesh_.areas.size(), 3);
  read_finite(frame, kMomentBytes, r.data(), static_cast<std::size_t>(r.size()), "position");
  return r;
}

NodeValues Trajectory::scalars(std::size_t frame) const {
  NodeValues s(static_cast<Index>(scalars_));
  read_finite(frame, bytes_of_frame(nodes(), fields_.size()), s.data(), scalars_, "scalar unknown");
  return s;
}

std::vector<float> Trajectory::field(std::size_t frame, std::size_t field) const {
  std::vector<float> values(nodes());
  try {
    read(place_of(frame) + bytes_of_frame(nodes(), field), values.data(),
         values.size() * sizeof(float));
  } catch (const std::runtime_error& e) {
    throw InputError(fmt::format("{}: {}", path_.string(), e.what()));
  }
  return values;
}

}  // namespace deform
