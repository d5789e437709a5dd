#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <dragcore/mass_properties.hpp>
#include <stdexcept>

#include "compare/peers/extents.hpp"
#include "compare/peers/peers.hpp"

namespace peers {
namespace {

struct Release {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* state) const { mj_deleteData(state); }
};

std::string numbers(const Eigen::Vector3d& v) { return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z()); }

/// A free body in MuJoCo's world, at rest at the origin: the axes of the world are those of the body.
class FreeBody : public Peer {
 public:
  FreeBody(const dragcore::TriangleMesh& mesh, double density, bool ellipsoid) {
    const dragcore::MeshMass mass =
        dragcore::inspect(mesh).closed ? dragcore::mass_properties(mesh, 1.0) : dragcore::sheet_mass_properties(mesh, 1.0);
    const Eigen::AlignedBox3d box = extents(mesh);
    const Eigen::Vector3d half = (0.5 * box.sizes()).cwiseMax(1e-9 * box.sizes().maxCoeff());  // MuJoCo refuses a size of zero
    const Eigen::Matrix3d& I = mass.inertia;
    const std::string geometry =
        ellipsoid ? fmt::format(R"(<geom type="box" size="{}" pos="{}" fluidshape="ellipsoid"/>)", numbers(half), numbers(box.center()))
                  : "";
    const std::string text = fmt::format(
        R"(<mujoco><option density="{:.17g}" gravity="0 0 0"/><compiler balanceinertia="true"/><worldbody><body><freejoint/>)"
        R"(<inertial pos="{}" mass="{:.17g}" fullinertia="{} {}"/>{}</body></worldbody></mujoco>)",
        density, numbers(mass.centre_of_mass), mass.mass, numbers(I.diagonal()), numbers({I(0, 1), I(0, 2), I(1, 2)}), geometry);

    const auto files = std::make_unique<mjVFS>();  // two megabytes
    mj_defaultVFS(files.get());
    mj_makeEmptyFileVFS(files.get(), "body.xml", static_cast<int>(text.size()));
    std::memcpy(files->filedata[0], text.data(), text.size());
    std::array<char, 500> fault{};
    model_.reset(mj_loadXML("body.xml", files.get(), fault.data(), static_cast<int>(fault.size())));
    mj_deleteVFS(files.get());
    if (!model_) throw std::runtime_error(std::string("MuJoCo refuses the body: ") + fault.data());
    state_.reset(mj_makeData(model_.get()));
    mj_forward(model_.get(), state_.get());
  }

  dragcore::Wrench wrench(const Eigen::Vector3d& wind) override {
    std::copy_n(wind.data(), 3, model_->opt.wind);
    mj_passive(model_.get(), state_.get());
    const mjtNum* load = state_->qfrc_passive;
    return {{load[0], load[1], load[2]}, {load[3], load[4], load[5]}};
  }

 private:
  std::unique_ptr<mjModel, Release> model_;
  std::unique_ptr<mjData, Release> state_;
};

}  // namespace

std::unique_ptr<Peer> mujoco_box(const dragcore::TriangleMesh& mesh, double density) {
  return std::make_unique<FreeBody>(mesh, density, false);
}

std::unique_ptr<Peer> mujoco_ellipsoid(const dragcore::TriangleMesh& mesh, double density) {
  return std::make_unique<FreeBody>(mesh, density, true);
}

}  // namespace peers
