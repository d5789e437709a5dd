#include <algorithm>
#include <charconv>
#include <cmath>
#include <dragcore/baked_file.hpp>
#include <fstream>
#include <sstream>
#include <string_view>

#include "io/hdf5_file.hpp"

namespace dragcore {

namespace {

constexpr const char* baked_schema = "dragcore.baked_body";
constexpr int most_frequency = 1024;  // 128 MB: more is taken for damage

struct MapName {
  const char* name;
  DirectionMap BakedBody::*map;
  int columns;
  const char* long_name;
};
constexpr std::array map_names = {
    MapName{"steady", &BakedBody::steady, 1, "force and torque coefficients over the direction of the flow, without spin"},
    MapName{"rate", &BakedBody::rate, 3, "change of the coefficients with spin times length per speed, over the direction of the flow"},
    MapName{"tumble", &BakedBody::tumble, 4, "coefficients in still air over the direction of the spin, and their change with the flow"}};

std::string hexadecimal(std::uint64_t value) {
  std::array<char, 16> digits;
  return {digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), value, 16).ptr};
}

std::uint64_t hash_from(const hdf5::File& file, const char* name, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size())
    fail(file, std::string("attribute ") + name + " is '" + text + "'; needed: a hexadecimal number of up to 16 digits");
  return value;
}

std::array<double, 4> numbers_of(const BakeError& e) { return {e.rms_force, e.worst_force, e.rms_torque, e.worst_torque}; }
BakeError error_from(const double* e) { return {e[0], e[1], e[2], e[3]}; }

void replace_all(std::string& text, std::string_view word, const std::string& by) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + by.size())) text.replace(at, word.size(), by);
}

/// Six of each row of eight: the zeros are of use to vectors only.
void write_array(std::ostream& out, const std::string& name, const DirectionMap& map) {
  const std::size_t rows = map.values.size() / 8;
  out << "static const float " << name << "[" << 6 * rows << "] = {\n";
  for (std::size_t row = 0; row < rows; ++row) {
    for (const std::size_t k : {0, 1, 2, 4, 5, 6}) {
      std::array<char, 24> word;
      out << std::string_view(word.data(),
                              static_cast<std::size_t>(std::to_chars(word.data(), word.data() + word.size(),
                                                                     double{map.values[8 * row + k]}, std::chars_format::scientific, 8)
                                                           .ptr -
                                                       word.data()))
          << "f" << (k < 6 ? "," : ",\n");
    }
  }
  out << "};\n";
}

// NAME, NODES and so on are replaced.
constexpr const char* c_code = R"(
/* Adds factor times a map's row to sum. The direction falls into a triangle of an octahedron that is folded out into a square. */
static void NAME_add(double sum[6], const float* map, int frequency, int columns, const double direction[3], const double* factor) {
  const double x = fabs(direction[0]), y = fabs(direction[1]), scale = frequency / (x + y + fabs(direction[2]));
  const double fold = direction[2] < 0 ? -direction[2] : 0, across = scale * (x + fold), up = scale * (y + fold);
  const int side = 2 * frequency + 1, right = direction[0] < 0 ? -1 : 1, above = direction[1] < 0 ? -side : side;
  const int i = across < frequency ? (int)across : frequency - 1, j = up < frequency ? (int)up : frequency - 1;
  const double a = across - i, b = up - j, rest = 1 - a - b, beyond = rest < 0 ? rest : 0;
  const int corner = frequency * (side + 1) + i * right + j * above;
  const int node[3] = {rest < 0 ? corner + right + above : corner, corner + right, corner + above};
  const double weight[3] = {fabs(rest), a + beyond, b + beyond};
  int n, c, k;
  for (n = 0; n < 3; ++n)
    for (c = 0; c < columns; ++c)
      for (k = 0; k < 6; ++k) sum[k] += weight[n] * factor[c] * map[6 * (node[n] * columns + c) + k];
}

/* Force [N] and torque about the centre (CENTRE) [N m], body frame.
 * flow: velocity of the air relative to the body at the centre [m/s]; spin: of the body relative to the air [rad/s]; density [kg/m^3].
 * Nothing is felt where they are not finite. */
static inline void NAME_wrench(const double flow[3], const double spin[3], double density, double force[3], double torque[3]) {
  const double length = LENGTH, still = 1e-280; /* no direction where a square is no normal number */
  double turned[3], sum[6] = {0, 0, 0, 0, 0, 0}, flow2 = 0, turned2 = 0, size2, taken = 0, most = 0, scale;
  int k;
  for (k = 0; k < 3; ++k) {
    turned[k] = SPINS * length * spin[k];
    flow2 += flow[k] * flow[k];
    turned2 += turned[k] * turned[k];
    force[k] = torque[k] = 0;
  }
  size2 = flow2 + turned2;
  if (!(size2 > still && size2 < 1e200)) return;
SUMS  /* The air takes energy: what the map errs to the other side is given back along the motion. */
  for (k = 0; k < 3; ++k) {
    taken += sum[k] * flow[k] - sum[3 + k] * turned[k];
    most += sum[k] * sum[k] + sum[3 + k] * sum[3 + k];
  }
  most = 1e-9 * sqrt(most * size2);
  scale = 0.5 * density * AREA * size2;
  for (k = 0; k < 3; ++k) {
    const double share = taken < most ? (most - taken) / size2 : 0;
    force[k] = scale * (sum[k] + share * flow[k]);
    torque[k] = scale * length * (sum[3 + k] - share * turned[k]);
  }
}
)";
constexpr const char* c_sums_straight = R"(  {
    const double one = 1;
    NAME_add(sum, NAME_steady, STEADY, 1, flow, &one);
  }
)";
constexpr const char* c_sums_spinning = R"(  {
    const double fast = sqrt(turned2), speed = sqrt(flow2), size = sqrt(size2), of_flow = flow2 / size2;
    const double by_spin = of_flow / (size + fast), by_flow = turned2 / size2 / (size + speed);
    const double slope[3] = {by_spin * turned[0], by_spin * turned[1], by_spin * turned[2]};
    const double tumble[4] = {turned2 / size2, by_flow * flow[0], by_flow * flow[1], by_flow * flow[2]};
    if (flow2 > still) {
      NAME_add(sum, NAME_steady, STEADY, 1, flow, &of_flow);
      if (turned2 > still) NAME_add(sum, NAME_rate, RATE, 3, flow, slope);
    }
    if (turned2 > still) NAME_add(sum, NAME_tumble, TUMBLE, 4, turned, tumble);
  }
)";

}  // namespace

BakedBody read_baked(const std::filesystem::path& path) {
  const hdf5::File file{"baked body", path};
  hdf5::Reader reader(file, baked_schema);
  BakedBody body;
  body.model = reader.text("model");
  body.surface_hash = hash_from(file, "surface_hash", reader.text("surface_hash"));
  body.model_hash = hash_from(file, "model_hash", reader.text("model_hash"));
  const auto numbers = [&](const char* name, const char* units, const std::vector<hsize_t>& needed, double* into) {
    reader.numbers<double>(name, units, [&](const std::vector<hsize_t>& shape) {
      if (shape != needed)
        fail(file, std::string("dataset ") + name + " has shape " + hdf5::to_text(shape) + "; needed: " + hdf5::to_text(needed));
      return into;
    });
    hsize_t count = 1;
    for (const hsize_t n : needed) count *= n;
    if (!std::all_of(into, into + count, [](double x) { return std::isfinite(x); }))
      fail(file, std::string("dataset ") + name + " holds a value that is not finite; bake the body again");
  };
  numbers("centre", "m", {3}, body.centre.data());
  numbers("area", "m^2", {1}, &body.area);
  numbers("length", "m", {1}, &body.length);
  numbers("rms_force", "1", {1}, &body.rms_force);
  if (!(body.area > 0.0) || !(body.length > 0.0)) fail(file, "area and length must be greater than 0; bake the body again");
  std::array<double, 4> error;
  numbers("error", "1", {4}, error.data());
  body.error = error_from(error.data());
  std::array<double, 3> ratios;
  numbers("spin_ratios", "1", {3}, ratios.data());
  if (ratios != BakedBody::spin_ratios) fail(file, "spin_ratios are not 0.1, 0.3 and 1; bake the body again");
  std::array<double, 12> spin_error;
  numbers("spin_error", "1", {3, 4}, spin_error.data());
  for (std::size_t k = 0; k < 3; ++k) body.spin_error[k] = error_from(spin_error.data() + 4 * k);
  for (const MapName& one : map_names) {
    DirectionMap& map = body.*one.map;
    // Both of the two maps for spin or none.
    if (one.columns > 1 && reader.text("spin") == "not baked") continue;
    reader.numbers<float>(one.name, "1", [&](const std::vector<hsize_t>& shape) {
      if (shape.size() != 4 || shape[0] != shape[1] || shape[0] < 3 || shape[0] % 2 == 0 || shape[0] > 2u * most_frequency + 1u ||
          shape[2] != static_cast<hsize_t>(one.columns) || shape[3] != 8)
        fail(file, std::string("dataset ") + one.name + " has shape " + hdf5::to_text(shape) + "; needed: [n, n, " +
                       std::to_string(one.columns) + ", 8] with n odd, from 3 to " + std::to_string(2 * most_frequency + 1));
      map.frequency = static_cast<int>(shape[0] / 2);
      map.columns = one.columns;
      map.values.resize(shape[0] * shape[0] * shape[2] * 8);
      return map.values.data();
    });
    if (!std::all_of(map.values.begin(), map.values.end(), [](float x) { return std::isfinite(x); }))
      fail(file, std::string("dataset ") + one.name + " holds a value that is not finite; bake the body again");
  }
  return body;
}

void write_baked(const std::filesystem::path& path, const BakedBody& body) {
  hdf5::write({"baked body", path}, baked_schema, [&](const hdf5::File& file, hid_t root) {
    hdf5::write_text(file, root, "model", body.model.empty() ? "unknown" : body.model);
    hdf5::write_text(file, root, "surface_hash", hexadecimal(body.surface_hash));
    hdf5::write_text(file, root, "model_hash", hexadecimal(body.model_hash));
    hdf5::write_text(file, root, "spin", body.tumble.frequency > 0 ? "baked" : "not baked");
    const auto numbers = [&](const char* name, const std::vector<hsize_t>& shape, const double* values, const char* units,
                             const char* long_name) { hdf5::write_numbers(file, root, name, shape, values, units, "body", long_name); };
    numbers("centre", {3}, body.centre.data(), "m", "where the flow is taken and torque is stored about");
    numbers("area", {1}, &body.area, "m^2", "of the coefficients: one side of the surface");
    numbers("length", {1}, &body.length, "m", "of the torque coefficients: from the centre to the farthest corner");
    numbers("rms_force", {1}, &body.rms_force, "1", "rms force coefficient over direction, without spin");
    numbers("error", {4}, numbers_of(body.error).data(), "1", "rms and worst of force, rms and worst of torque, without spin");
    numbers("spin_ratios", {3}, BakedBody::spin_ratios.data(), "1", "spin times length over speed");
    std::vector<double> spin_error;
    for (const BakeError& one : body.spin_error)
      for (const double number : numbers_of(one)) spin_error.push_back(number);
    numbers("spin_error", {3, 4}, spin_error.data(), "1", "as error, at each spin ratio");
    for (const MapName& one : map_names)
      if (const DirectionMap& map = body.*one.map; map.frequency > 0) {
        const hsize_t side = static_cast<hsize_t>(map.side());
        hdf5::write_numbers(file, root, one.name, {side, side, static_cast<hsize_t>(map.columns), 8}, map.values.data(), "1", "body",
                            one.long_name);
      }
  });
}

void write_c_header(const std::filesystem::path& path, const BakedBody& body, const std::string& name) {
  const hdf5::File file{"C header", path};
  constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_", digits = "0123456789";
  if (name.empty() || digits.find(name[0]) != std::string_view::npos ||
      name.find_first_not_of(std::string(letters).append(digits)) != std::string::npos)
    throw std::invalid_argument("C header: the name '" + name +
                                "' must consist of letters, digits and underscores, and not begin with a digit");
  const bool spins = body.tumble.frequency > 0;
  const auto number = [](double value) {
    std::array<char, 32> word;
    return std::string(word.data(), std::to_chars(word.data(), word.data() + word.size(), value).ptr);
  };
  std::string code = c_code;
  replace_all(code, "SUMS", spins ? c_sums_spinning : c_sums_straight);
  replace_all(code, "SPINS", spins ? "1" : "0");
  replace_all(code, "LENGTH", number(body.length));
  replace_all(code, "AREA", number(body.area));
  replace_all(code, "STEADY", std::to_string(body.steady.frequency));
  replace_all(code, "RATE", std::to_string(body.rate.frequency));
  replace_all(code, "TUMBLE", std::to_string(body.tumble.frequency));
  replace_all(code, "CENTRE", number(body.centre.x()) + ", " + number(body.centre.y()) + ", " + number(body.centre.z()) + " m");
  replace_all(code, "NAME", name);  // last: it may contain the other words
  // Under a temporary name first: a full disk leaves no half header.
  const std::filesystem::path partial = path.string() + ".partial";
  std::ofstream out(partial, std::ios::binary);
  std::string model = body.model;
  replace_all(model, "*/", "* /");
  out << "/* Force and torque of the air on a body, baked by dragcore. C99; include it in one file.\n * " << model << "\n * surface "
      << hexadecimal(body.surface_hash) << ", model " << hexadecimal(body.model_hash)
      << "\n * error of force: " << number(body.error.rms_force) << " rms, " << number(body.error.worst_force)
      << " worst; of torque: " << number(body.error.rms_torque) << " rms, " << number(body.error.worst_torque)
      << " worst; of the rms force, and of that times the length */\n#include <math.h>\n\n";
  write_array(out, name + "_steady", body.steady);
  if (spins) {
    write_array(out, name + "_rate", body.rate);
    write_array(out, name + "_tumble", body.tumble);
  }
  out << code;
  out.close();
  std::error_code fault;
  if (out) std::filesystem::rename(partial, path, fault);
  if (!out || fault) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    fail(file, "cannot be written; check the folder and the free space");
  }
}

}  // namespace dragcore
