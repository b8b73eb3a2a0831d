// Copyright 2026 gearbox_monitor authors
// SPDX-License-Identifier: Apache-2.0


// The EKF of this package as a C++ programmer writes it with Eigen: the reference for speed.
//
// State x1, x2, x3, x4, tau_K; equations of gearbox_monitor/plant/drive.py without a load on the
// arm; one RK4 step per sample; process noise in halves before and after; update with both
// positions in Joseph's form; NIS. Matrices of fixed size, no structure used by hand.
#include <cmath>

#include <Eigen/Core>
#include <Eigen/LU>

#if !EIGEN_VERSION_AT_LEAST(3, 3, 0)
#error "Eigen is too old, expected 3.3 or newer"
#endif

namespace
{
using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

struct Drive
{
  double inverse_m1, inverse_m2, damping, viscous, coulomb, sharpness, position_gain, offset;
};

constexpr double TWO_OVER_PI = 0.63661977236758134308;

Vector5 derivative(const Vector5 & x, double u, const Drive & d)
{
  const double coupled = d.damping * (x[2] - x[3]) + x[4];
  const double friction =
    d.viscous * x[2] + d.coulomb * TWO_OVER_PI * std::atan(d.sharpness * x[2]);
  Vector5 rate;
  rate << x[2], x[3],
    (u + d.offset - coupled - friction - d.position_gain * x[0]) * d.inverse_m1,
    coupled * d.inverse_m2, 0.0;
  return rate;
}

Matrix5 jacobian(const Vector5 & x, const Drive & d)
{
  const double v = d.sharpness * x[2];
  const double slope = d.viscous + d.coulomb * TWO_OVER_PI * d.sharpness / (1.0 + v * v);
  Matrix5 a = Matrix5::Zero();
  a(0, 2) = 1.0;
  a(1, 3) = 1.0;
  a(2, 0) = -d.position_gain * d.inverse_m1;
  a(2, 2) = -(d.damping + slope) * d.inverse_m1;
  a(2, 3) = d.damping * d.inverse_m1;
  a(2, 4) = -d.inverse_m1;
  a(3, 2) = d.damping * d.inverse_m2;
  a(3, 3) = -d.damping * d.inverse_m2;
  a(3, 4) = d.inverse_m2;
  return a;
}

// Advance x by one RK4 step of h s and return its tangent: that of the step itself, or the usual
// I + h A + h^2 A^2 / 2.
template<bool exact>
Matrix5 propagate(Vector5 & x, double u, double h, const Drive & d)
{
  const Vector5 k1 = derivative(x, u, d);
  const Vector5 x2 = x + 0.5 * h * k1;
  const Vector5 k2 = derivative(x2, u, d);
  const Vector5 x3 = x + 0.5 * h * k2;
  const Vector5 k3 = derivative(x3, u, d);
  const Vector5 x4 = x + h * k3;
  const Vector5 k4 = derivative(x4, u, d);
  const Matrix5 identity = Matrix5::Identity();
  const Matrix5 m1 = jacobian(x, d);
  Matrix5 tangent;
  if (exact) {
    const Matrix5 m2 = jacobian(x2, d) * (identity + 0.5 * h * m1);
    const Matrix5 m3 = jacobian(x3, d) * (identity + 0.5 * h * m2);
    const Matrix5 m4 = jacobian(x4, d) * (identity + h * m3);
    tangent = identity + h / 6.0 * (m1 + 2.0 * (m2 + m3) + m4);
  } else {
    tangent = identity + h * m1 + 0.5 * h * h * m1 * m1;
  }
  x += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
  return tangent;
}

// values: Drive, Q's diagonal (per s), R's diagonal, P's diagonal at the start.
template<bool exact>
void run(
  long n, double h, const double * values, const double * u, const double * y, double * states,
  double * nis)
{
  const Drive d{values[0], values[1], values[2], values[3], values[4], values[5], values[6],
    values[7]};
  const Vector5 half = 0.5 * h * Eigen::Map<const Vector5>(values + 8);
  const Eigen::Vector2d r(values[13], values[14]);
  Matrix5 P = Eigen::Map<const Vector5>(values + 15).asDiagonal();
  Vector5 x;
  x << y[0], y[1], 0.0, 0.0, 0.0;
  Eigen::Matrix<double, 2, 5> H;
  H.setIdentity();
  for (long k = 1; k < n; ++k) {
    const Matrix5 F = propagate<exact>(x, u[k - 1], h, d);
    P.diagonal() += half;
    const Matrix5 FP = F * P;
    P.noalias() = FP * F.transpose();
    P.diagonal() += half;
    const Eigen::Vector2d e = Eigen::Map<const Eigen::Vector2d>(y + 2 * k) - x.head<2>();
    Eigen::Matrix2d S = P.topLeftCorner<2, 2>();
    S.diagonal() += r;
    const Eigen::Matrix2d inverse = S.inverse();
    const Eigen::Matrix<double, 5, 2> K = P.leftCols<2>() * inverse;
    nis[k] = e.dot(inverse * e);
    x += K * e;
    const Matrix5 rest = Matrix5::Identity() - K * H;
    const Matrix5 shrunk = rest * P;
    P.noalias() = shrunk * rest.transpose();
    P.noalias() += K * r.asDiagonal() * K.transpose();
    Eigen::Map<Vector5>(states + 5 * k) = x;
  }
}
}  // namespace

// u [n], y [n, 2]; written from the second row on: states [n, 5], nis [n].
extern "C" void eigen_ekf(
  long n, double h, const double * values, const double * u, const double * y, double * states,
  double * nis)
{
  run<false>(n, h, values, u, y, states, nis);
}

extern "C" void eigen_ekf_exact(
  long n, double h, const double * values, const double * u, const double * y, double * states,
  double * nis)
{
  run<true>(n, h, values, u, y, states, nis);
}
