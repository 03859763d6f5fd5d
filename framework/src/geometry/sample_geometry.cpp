#include "geometry/sample_geometry.h"

#include <cmath>

namespace deform {

using Field = GeometryBlock;

Vec3 unit_normal(const Vec3& r_1, const Vec3& r_2) {
  const Vec3 cross = r_1.cross(r_2);
  const double length = cross.norm();
  return length > 0 ? Vec3(cross / length) : Vec3(Vec3::Zero());
}

void write_sample(double* data, Index stride, Index s, const SampleGeometry& g) {
  const auto put = [&](int field, double value) { data[field * stride + s] = value; };
  const auto put_vector = [&](int field, const Vec3& v) {
    for (int c = 0; c < 3; ++c) put(field + c, v[c]);
  };
  for (int m = 0; m < 5; ++m) put_vector(3 * m, g.jet[static_cast<std::size_t>(m)]);
  put_vector(Field::kNormal, g.n);

  const Vec3& r_1 = g.jet[0];
  const Vec3& r_2 = g.jet[1];
  const double G_11 = r_1.dot(r_1), G_12 = r_1.dot(r_2), G_22 = r_2.dot(r_2);  // (3)
  put(Field::kMetric + 0, G_11);
  put(Field::kMetric + 1, G_12);
  put(Field::kMetric + 2, G_22);
  std::array<double, 3> B{};
  for (std::size_t ij = 0; ij < 3; ++ij) {
    B[ij] = g.n.dot(g.jet[2 + ij]);  // (6)
    put(Field::kCurvature + static_cast<int>(ij), B[ij]);
  }

  // A degenerate metric (a tangent that is not computable at the border, or a crushed cell) has no
  // reciprocal: all that needs it is 0, as the paper's section 4 ends.
  const double det = G_11 * G_22 - G_12 * G_12;
  const double inverse = det > 0 ? 1 / det : 0.0;
  put(Field::kAreaElement, det > 0 ? std::sqrt(det) : 0.0);
  const double R_11 = G_22 * inverse, R_12 = -G_12 * inverse, R_22 = G_11 * inverse;  // (13)
  put(Field::kReciprocal + 0, R_11);
  put(Field::kReciprocal + 1, R_12);
  put(Field::kReciprocal + 2, R_22);
  for (int ij = 0; ij < 3; ++ij) {  // (15)
    const Vec3& r_ij = g.jet[static_cast<std::size_t>(2 + ij)];
    const double along_1 = r_ij.dot(r_1), along_2 = r_ij.dot(r_2);
    put(Field::kChristoffel + ij, R_11 * along_1 + R_12 * along_2);
    put(Field::kChristoffel + 3 + ij, R_12 * along_1 + R_22 * along_2);
  }
  put(Field::kWeingarten + 0, (B[1] * G_12 - B[0] * G_22) * inverse);  // d_11 (8)
  put(Field::kWeingarten + 1, (B[2] * G_12 - B[1] * G_22) * inverse);  // d_12
  put(Field::kWeingarten + 2, (B[0] * G_12 - B[1] * G_11) * inverse);  // d_21
  put(Field::kWeingarten + 3, (B[1] * G_12 - B[2] * G_11) * inverse);  // d_22
}

}  // namespace deform
