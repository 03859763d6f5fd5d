#include "deform/record/trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "deform/error.h"

#include "record/trajectory_format.h"

namespace deform {

using namespace trajectory_format;

Trajectory::Trajectory(std::filesystem::path file)
    : path_(std::move(file)), file_(path_, std::ios::binary) {
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
  std::string magic(kMagic.size(), '\0');
  read(0, magic.data(), magic.size());
  if (magic != kMagic) throw std::runtime_error("it does not begin like one of this version");
  std::uint64_t length = 0;
  read(kMagic.size(), &length, sizeof length);
  if (length > kMostHeader) throw std::runtime_error("its header is too long");
  std::string text(length, '\0');
  read(kMagic.size() + sizeof length, text.data(), length);
  const Json header = Json::parse(text);
  first_frame_ = kMagic.size() + sizeof length + length;
  const auto count = [&header](const char* key) {
    const auto value = header.at(key).get<std::size_t>();
    if (value > std::numeric_limits<std::int32_t>::max()) throw std::runtime_error("too large");
    return value;
  };
  mesh_.areas.resize(static_cast<Index>(count("nodes")));
  mesh_.size = header.at("size").get<double>();
  for (const Json& field : header.at("fields")) fields_.push_back(field_of(field));
  read_mesh(count("faces"), count("corners"));
}

void Trajectory::read_mesh(std::size_t faces, std::size_t corners) {
  const std::size_t bytes = std::filesystem::file_size(path_);
  if (first_frame_ + 24 * nodes() + 4 * (faces + 1 + corners) > bytes)
    throw std::runtime_error("it is cut off");
  mesh_.parameters.resize(mesh_.areas.size(), 2);
  mesh_.faces.begin.resize(faces + 1);
  mesh_.faces.nodes.resize(corners);
  const auto take = [this](auto* to, std::size_t count) {
    read(first_frame_, to, count * sizeof *to);
    first_frame_ += count * sizeof *to;
  };
  take(mesh_.parameters.data(), 2 * nodes());
  take(mesh_.areas.data(), nodes());
  take(mesh_.faces.begin.data(), faces + 1);
  take(mesh_.faces.nodes.data(), corners);
}

std::size_t Trajectory::frame_bytes() const { return bytes_of_frame(nodes(), fields_.size()); }

void Trajectory::find_moments() {
  const std::size_t bytes = std::filesystem::file_size(path_);
  for (std::size_t at = first_frame_; at + frame_bytes() <= bytes; at += frame_bytes()) {
    std::int64_t step = 0;
    double time = 0;
    read(at, &step, sizeof step);
    read(at + sizeof step, &time, sizeof time);
    if (!moments_.empty() && step <= moments_.back().step)
      throw std::runtime_error("its steps do not ascend");
    moments_.push_back({step, time});
  }
}

void Trajectory::read(std::size_t at, void* to, std::size_t bytes) const {
  file_.clear();
  file_.seekg(static_cast<std::streamoff>(at));
  file_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
  if (!file_) throw std::runtime_error("it cannot be read, or is cut off");
}

NodeVectors Trajectory::positions(std::size_t frame) const {
  NodeVectors r(mesh_.areas.size(), 3);
  read(first_frame_ + frame * frame_bytes() + kMomentBytes, r.data(),
       static_cast<std::size_t>(r.size()) * sizeof(double));
  return r;
}

std::vector<float> Trajectory::field(std::size_t frame, std::size_t field) const {
  std::vector<float> values(nodes());
  read(first_frame_ + frame * frame_bytes() + bytes_of_frame(nodes(), field), values.data(),
       values.size() * sizeof(float));
  return values;
}

}  // namespace deform
