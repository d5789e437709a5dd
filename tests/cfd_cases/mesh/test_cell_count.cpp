#include <catch2/catch.hpp>
#include <cmath>

#include "cfd_cases/flow_case/matrix.hpp"
#include "cfd_cases/mesh/cell_count.hpp"

using namespace cfd_cases;

namespace {

constexpr PoseDegrees kTilted{.incidence = 30.0};

SizeIntegrals integrals(const dragcore::Shape& shape, double refinement, Symmetry symmetry, const MeshRecipe& recipe = {}) {
  MeshRecipe refined = recipe;
  refined.refinement = refinement;
  return integrate_size(shape, kTilted.radians(), refined, symmetry);
}

}  // namespace

TEST_CASE("air of one size holds its volume over the cube of that size", "[cfd_cases][mesh][analytic]") {
  MeshRecipe uniform;
  uniform.far_size = uniform.body_size = uniform.wake_size = uniform.outer_size = 0.5;
  const auto sum = integrate_size(dragcore::Box{}, {}, uniform, Symmetry::none);
  // 24 x 17 x 17 less the cube; its six sides and those of the air. Pieces and air end at the same planes: exact.
  CHECK(sum.volume == Approx((24.0 * 17.0 * 17.0 - 1.0) * 8.0).epsilon(1e-10));
  CHECK(sum.surface == Approx((2.0 * 17.0 * 17.0 + 4.0 * 24.0 * 17.0 + 6.0) * 4.0).epsilon(1e-10));
}

TEST_CASE("size grows around a sphere as worked out by hand", "[cfd_cases][mesh][analytic]") {
  // Only the body refines, and nothing bounds the size: h = a + g (r - R). The integral of 4 pi r^2 h^-3 over the air has a closed form up
  // to the nearest side; beyond, where h > 1.5, less than 6 % of it is left.
  MeshRecipe body_only;
  body_only.wake_size = body_only.outer_size = body_only.far_size = 100.0;
  const double a = body_only.body_size, g = body_only.growth, R = 0.5, far = 8.5;
  const auto antiderivative = [&](double h) {  // of (h - c)^2 h^-3 / g^3 with r = (h - c) / g
    const double c = a - g * R;
    return (std::log(h) + 2.0 * c / h - 0.5 * c * c / (h * h)) / (g * g * g);
  };
  const double inner = 4.0 * M_PI * (antiderivative(a + g * (far - R)) - antiderivative(a));
  const double found = integrate_size(dragcore::Sphere{}, {}, body_only, Symmetry::none).volume;
  CHECK(found > 0.97 * inner);  // the midpoint rule is 2 % low
  CHECK(found < 1.06 * inner);
}

TEST_CASE("the half model of a symmetric case has half the air", "[cfd_cases][mesh][invariance]") {
  for (const dragcore::Shape& shape : {dragcore::Shape(dragcore::Plate{}), dragcore::Shape(dragcore::Cone{})}) {
    const auto half = integrals(shape, 1.0, Symmetry::plane_y), whole = integrals(shape, 1.0, Symmetry::none);
    // Rounding: the whole is first cut in the middle, so that its pieces are those of the half and their mirror images.
    CHECK(2.0 * half.volume == Approx(whole.volume).epsilon(1e-6));
    // The plane of symmetry is a surface of the half alone.
    CHECK(2.0 * half.surface > whole.surface);
  }
}

TEST_CASE("refining by n takes n^3 cells in the air and n^2 on its boundary", "[cfd_cases][mesh][convergence]") {
  const auto medium = integrals(dragcore::Cone{}, 1.0, Symmetry::plane_y), fine = integrals(dragcore::Cone{}, 0.5, Symmetry::plane_y);
  CHECK(fine.volume == Approx(8.0 * medium.volume).epsilon(1e-12));
  CHECK(fine.surface == Approx(4.0 * medium.surface).epsilon(1e-12));
}

TEST_CASE("the number of cells does not depend on the size of the body", "[cfd_cases][mesh][invariance]") {
  const auto small = integrals(dragcore::Box{}, 1.0, Symmetry::plane_y);
  const auto large = integrals(dragcore::Box{.length = 3.0, .width = 3.0, .height = 3.0}, 1.0, Symmetry::plane_y);
  // A piece whose reach is just that of the limit may be cut or not, by rounding.
  CHECK(large.volume == Approx(small.volume).epsilon(1e-3));
}
