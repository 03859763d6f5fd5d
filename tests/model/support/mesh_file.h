/// Mesh files that tests write: pieces of known surfaces cut into triangles, and any text.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <unistd.h>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "deform/types.h"

namespace deform::test {

/// A folder of its own, removed in the end.
class MeshFolder {
 public:
  MeshFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "deform_mesh_XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~MeshFolder() { std::filesystem::remove_all(folder_); }
  MeshFolder(const MeshFolder&) = delete;
  MeshFolder& operator=(const MeshFolder&) = delete;

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }

 private:
  std::filesystem::path folder_;
};

/// Vertices and triangles.
struct MeshText {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::size_t, 3>> triangles;

  [[nodiscard]] std::string obj() const {
    std::string text;
    for (const Vec3& v : vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : triangles)
      text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
    return text;
  }
  [[nodiscard]] std::string off() const {
    std::string text = fmt::format("OFF\n{} {} 0\n", vertices.size(), triangles.size());
    for (const Vec3& v : vertices) text += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
    for (const auto& t : triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    return text;
  }
};

/// A piece of a parametrised surface over [0, size_1] × [0, size_2], in n_1 × n_2 cells of two
/// triangles each; inner vertices are moved by up to `jitter` of a cell.
inline MeshText patch(const std::function<Vec3(double, double)>& r, Vec2 size, std::size_t n_1,
                      std::size_t n_2, double jitter = 0) {
  MeshText mesh;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-jitter, jitter);
  for (std::size_t j = 0; j <= n_2; ++j)
    for (std::size_t i = 0; i <= n_1; ++i) {
      const bool is_inside = i > 0 && i < n_1 && j > 0 && j < n_2;
      const double u = static_cast<double>(i) + (is_inside ? uniform(random) : 0),
                   v = static_cast<double>(j) + (is_inside ? uniform(random) : 0);
      mesh.vertices.push_back(
          r(size[0] * u / static_cast<double>(n_1), size[1] * v / static_cast<double>(n_2)));
    }
  for (std::size_t j = 0; j < n_2; ++j)
    for (std::size_t i = 0; i < n_1; ++i) {
      const std::size_t a = j * (n_1 + 1) + i, b = a + 1, c = b + n_1 + 1, d = a + n_1 + 1;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

/// An octahedron each of whose faces is cut into 4ᵏ, on the unit sphere.
inline MeshText sphere(int k) {
  MeshText mesh;
  for (const double s : {1.0, -1.0})
    for (Index c = 0; c < 3; ++c) mesh.vertices.emplace_back(s * Vec3::Unit(c));
  mesh.triangles = {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2},
                    {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}};
  for (; k > 0; --k) {
    std::map<std::pair<std::size_t, std::size_t>, std::size_t> middles;
    const auto middle = [&](std::size_t a, std::size_t b) {
      const auto [at, is_new] =
          middles.emplace(std::pair(std::min(a, b), std::max(a, b)), mesh.vertices.size());
      if (is_new) mesh.vertices.emplace_back((mesh.vertices[a] + mesh.vertices[b]).normalized());
      return at->second;
    };
    std::vector<std::array<std::size_t, 3>> finer;
    for (const auto& [a, b, c] : mesh.triangles) {
      const std::size_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

}  // namespace deform::test
