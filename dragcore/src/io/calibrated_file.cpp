#include <algorithm>
#include <cmath>
#include <dragcore/calibrated_file.hpp>
#include <dragcore/law_file.hpp>

#include "io/hdf5_file.hpp"
#include "support/require.hpp"

namespace dragcore {

namespace {

constexpr const char* calibrated_schema = "dragcore.calibrated_model";

std::array<double, 8> numbers_of(const CalibrationError& e) {
  return {e.mean_force, e.worst_force, e.mean_drag, e.worst_drag, e.mean_moment, e.worst_moment, e.reference, static_cast<double>(e.poses)};
}

/// A law's text, by the reader of law files.
LawFile law_from(const hdf5::File& file, const std::string& key, const std::string& text) {
  if (text.empty()) fail(file, "attribute " + key + " is missing; calibrate the body again");
  try {
    return parse_law(text, key);
  } catch (const std::runtime_error& fault) {
    fail(file, fault.what());
  }
}

Pillow pillow_from(const hdf5::File& file, const double* numbers) {
  if (!(numbers[0] >= 0.0 && numbers[0] <= largest_tilt) || !(numbers[1] >= 0.0 && numbers[1] < 1e6))
    fail(file, "dataset pillow holds a factor or gain out of range; calibrate the body again");
  if (numbers[0] == 0.0) return {};
  return {.form = PillowForm::tilt, .factor = numbers[0], .viscous_gain = numbers[1]};
}

}  // namespace

CalibratedModel read_calibrated(const std::filesystem::path& path) {
  const hdf5::File file{"calibrated model", path};
  hdf5::Reader reader(file, calibrated_schema);
  const auto numbers = [&](const char* name, const char* units, std::size_t least, std::size_t most) {
    std::vector<double> found;
    reader.numbers<double>(name, units, [&](const std::vector<hsize_t>& shape) {
      if (shape.size() != 1 || shape[0] < least || shape[0] > most)
        fail(file, std::string("dataset ") + name + " has shape " + hdf5::to_text(shape) + "; needed: " + hdf5::to_text({most}));
      found.resize(shape[0]);
      return found.data();
    });
    if (!std::all_of(found.begin(), found.end(), [](double x) { return std::isfinite(x); }))
      fail(file, std::string("dataset ") + name + " holds a value that is not finite; calibrate the body again");
    return found;
  };
  CalibratedModel result;
  LawFile law = law_from(file, "law", reader.text("law"));
  result.model.law = law.law;
  result.provenance = std::move(law.provenance);
  result.model.precision = Precision::single;
  const std::vector<double> pillow = numbers("pillow", "1", 2, 4);
  result.model.pillow = pillow_from(file, pillow.data());
  if (const std::string sheet = reader.text("sheet_law"); !sheet.empty()) {
    if (pillow.size() != 4) fail(file, "dataset pillow has no numbers for the sheets; calibrate the body again");
    result.model.sheets = SheetModel{law_from(file, "sheet_law", sheet).law, pillow_from(file, pillow.data() + 2)};
  }

  auto correction = std::make_shared<Correction>();
  correction->origin = reader.text("origin");
  const std::string viscous = reader.text("viscous");
  if (viscous != "yes" && viscous != "no") fail(file, "attribute viscous is '" + viscous + "'; needed: 'yes' or 'no'");
  correction->viscous = viscous == "yes";
  const std::vector<double> body = numbers("body", "1", 17, 17), reynolds = numbers("reynolds", "1", 2, 2);
  correction->body.emplace();
  std::copy(body.begin(), body.end(), correction->body->begin());
  correction->least_reynolds = reynolds[0], correction->most_reynolds = reynolds[1];
  reader.numbers<float>("map", "1", [&](const std::vector<hsize_t>& shape) {
    if (shape.size() != 4 || shape[0] != shape[1] || shape[0] < 3 || shape[0] > 2049 || shape[0] % 2 == 0 || shape[2] != 1 || shape[3] != 8)
      fail(file, "dataset map has shape " + hdf5::to_text(shape) + "; needed: [n, n, 1, 8] with n odd, from 3 to 2049");
    correction->map = DirectionMap::zero(static_cast<int>(shape[0] / 2), 1);
    return correction->map.values.data();
  });
  try {
    validate(*correction);
  } catch (const std::invalid_argument& fault) {
    fail(file, fault.what());
  }
  result.model.correction = std::move(correction);

  result.most_mach = numbers("most_mach", "1", 1, 1)[0];
  const std::vector<double> e = numbers("error", "1", 8, 8);
  result.error = {e[0], e[1], e[2], e[3], e[4], e[5], e[6], static_cast<int>(e[7])};
  return result;
}

void write_calibrated(const std::filesystem::path& path, const CalibratedModel& calibrated) {
  const Model& model = calibrated.model;
  if (!model.correction || !model.correction->body)
    throw std::invalid_argument("write_calibrated: the model has no correction that knows its body; calibrate one");
  validate(*model.correction);
  const auto pillow_numbers = [](const Pillow& pillow) {
    if (pillow.form != PillowForm::none && pillow.form != PillowForm::tilt)
      throw std::invalid_argument("write_calibrated: a pillow of the form '" + to_string(pillow.form) +
                                  "', but 'tilt' or 'none' is needed");
    return pillow.form == PillowForm::none ? std::array{0.0, 0.0} : std::array{pillow.factor, pillow.viscous_gain};
  };
  const auto own = pillow_numbers(model.pillow), of_sheets = model.sheets ? pillow_numbers(model.sheets->pillow) : own;
  const auto error = numbers_of(calibrated.error);
  if (!std::isfinite(calibrated.most_mach) || !std::all_of(error.begin(), error.end(), [](double x) { return std::isfinite(x); }))
    throw std::invalid_argument(
        "write_calibrated: an error or the Mach number is not finite, which no reader would take; look at what the model was fitted to");
  const std::string law = law_text({model.law, calibrated.provenance});
  const std::string sheet_law = model.sheets ? law_text({model.sheets->law, {}}) : "";
  hdf5::write({"calibrated model", path}, calibrated_schema, [&](const hdf5::File& file, hid_t root) {
    hdf5::write_text(file, root, "law", law);
    if (model.sheets) hdf5::write_text(file, root, "sheet_law", sheet_law);
    hdf5::write_text(file, root, "origin", model.correction->origin.empty() ? "unknown" : model.correction->origin);
    hdf5::write_text(file, root, "viscous", model.correction->viscous ? "yes" : "no");
    const auto numbers = [&](const char* name, const std::vector<double>& values, const char* long_name) {
      hdf5::write_numbers(file, root, name, {values.size()}, values.data(), "1", "body", long_name);
    };
    const ShapeMoments& body = *model.correction->body;
    numbers("body", {body.begin(), body.end()}, "second and third moments of the surface over area and powers of radius; volume over both");
    // Without a bound there is none that a file could hold: the largest number stands for it.
    numbers("reynolds", {model.correction->least_reynolds, std::min(model.correction->most_reynolds, std::numeric_limits<double>::max())},
            "least and most, on the diameter 2 radius, that the body was calibrated at");
    numbers("pillow", model.sheets ? std::vector{own[0], own[1], of_sheets[0], of_sheets[1]} : std::vector{own[0], own[1]},
            "factor of the tilt form and its gain with viscosity; of sheets, too, where there are both");
    numbers("most_mach", {calibrated.most_mach}, "beyond it nothing is known");
    numbers("error", {error.begin(), error.end()},
            "in poses left out: mean and worst of force, of drag and of moment; mean u of the references; number of poses");
    const DirectionMap& map = model.correction->map;
    const auto side = static_cast<hsize_t>(map.side());
    hdf5::write_numbers(file, root, "map", {side, side, 1, 8}, map.values.data(), "1", "body",
                        "force and torque coefficients beyond the law over the direction of the flow, over area and radius of the surface");
  });
}

}  // namespace dragcore
