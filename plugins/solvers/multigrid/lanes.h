/// Vectors of nodes in single precision, four lanes each: three components and a fourth that is 0.
#pragma once

#include <cstring>
#include <vector>

namespace multigrid {

struct Lanes {
  using Register [[gnu::vector_size(16)]] = float;
  Register v{};

  static Lanes load(const float* from) {
    Lanes x;
    std::memcpy(&x.v, from, sizeof x.v);
    return x;
  }
  float operator[](int c) const { return v[c]; }
  void set(int c, float value) { v[c] = value; }

  Lanes& operator+=(const Lanes& o) {
    v += o.v;
    return *this;
  }
  Lanes& operator-=(const Lanes& o) {
    v -= o.v;
    return *this;
  }
  friend Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
  friend Lanes operator-(Lanes a, const Lanes& b) { return a -= b; }
  friend Lanes operator*(const Lanes& a, const Lanes& b) { return {a.v * b.v}; }
  friend Lanes operator*(float s, const Lanes& a) { return {s * a.v}; }
};

/// The sum over the three components, in double precision.
inline double dot(const Lanes& a, const Lanes& b) {
  return static_cast<double>(a[0]) * static_cast<double>(b[0]) +
         static_cast<double>(a[1]) * static_cast<double>(b[1]) +
         static_cast<double>(a[2]) * static_cast<double>(b[2]);
}

using LaneVector = std::vector<Lanes>;

}  // namespace multigrid
