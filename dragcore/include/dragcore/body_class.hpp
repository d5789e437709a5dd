#pragma once

#include <string>

namespace dragcore {

/// What a surface is to the air; found by Surface from the mesh, and what decides which law serves it best (law_for()).
enum class BodyClass {
  sheet,   ///< two-sided, open, or closed with a mean thickness below 0.12 of its middle extent: plates, discs, bowls
  sharp,   ///< closed, most of its area flat along some direction and bounded by sharp edges: boxes, prisms, cones
  smooth,  ///< closed, more than half of its area curved in every direction: balls, teardrops
};

std::string to_string(BodyClass body_class);

}  // namespace dragcore
