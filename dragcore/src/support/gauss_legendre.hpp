#pragma once

#include <array>
#include <cmath>
#include <numbers>

namespace dragcore {

/// Points and weights of Gauss and Legendre on [0, 1], exact to degree 2 N - 1.
template <int N>
struct GaussLegendre {
  std::array<double, N> point{}, weight{};

  GaussLegendre() {
    for (int i = 0; i < N; ++i) {
      double x = std::cos(std::numbers::pi * (i + 0.75) / (N + 0.5)), slope = 1.0;
      for (int newton = 0; newton < 8; ++newton) {  // quadratic convergence from an estimate good to 1e-3: 4 would do
        double previous = 1.0, value = x;
        for (int k = 2; k <= N; ++k) {
          const double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
          previous = value;
          value = next;
        }
        slope = N * (x * value - previous) / (x * x - 1.0);
        x -= value / slope;
      }
      point[i] = 0.5 * (1.0 - x);
      weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
  }
};

}  // namespace dragcore
