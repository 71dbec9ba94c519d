// A gate (gates.py) with Gazebo's server in this process, a tick at a time.
//
//   gate_sea WORLD.sdf STEPS NAME...
//
// The sea is Gazebo's own: Hydrodynamics, on DART. In every step a helmsman turns and drives each
// vehicle by thruster and rudder to its commanded velocity, and holds its depth.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <ignition/common/Console.hh>
#include <ignition/gazebo/EntityComponentManager.hh>
#include <ignition/gazebo/Link.hh>
#include <ignition/gazebo/Model.hh>
#include <ignition/gazebo/Server.hh>
#include <ignition/gazebo/ServerConfig.hh>
#include <ignition/gazebo/System.hh>
#include <ignition/gazebo/components/Model.hh>
#include <ignition/gazebo/components/Name.hh>

using namespace ignition;
using namespace ignition::gazebo;

struct Vehicle {
  std::string name;
  Entity link{kNullEntity};
  math::Vector3d wanted, at;
  double speed{0.0}, way{0.0}, depth{0.0};
  bool isPlaced{false};
};

class Helmsman : public System, public ISystemPreUpdate, public ISystemUpdate {
  public: explicit Helmsman(std::vector<Vehicle> &_fleet) : fleet(_fleet) {}

  public: void PreUpdate(const UpdateInfo &_info, EntityComponentManager &_ecm) override {
    for (auto &v : this->fleet) {
      if (v.link == kNullEntity) {
        auto model = _ecm.EntityByComponents(components::Model(), components::Name(v.name));
        v.link = Model(model).LinkByName(_ecm, "hull");
        Link(v.link).EnableVelocityChecks(_ecm);
      }
      Link hull(v.link);
      const auto pose = hull.WorldPose(_ecm);
      const auto flow = hull.WorldLinearVelocity(_ecm);
      const auto turn = hull.WorldAngularVelocity(_ecm);
      if (_info.paused || !pose || !flow || !turn)
        continue;
      const auto ahead = pose->Rot().RotateVector(math::Vector3d::UnitX);
      const double speed = v.wanted.Length();
      const double off = speed > 0.0
        ? std::atan2(ahead.Cross(v.wanted).Z(), ahead.Dot(v.wanted)) : 0.0;
      const double goal = speed * std::max(0.0, std::cos(off));
      const double surge = 60.0 * goal * goal + 800.0 * (goal - flow->Dot(ahead));
      const double rudder = 900.0 * off - 500.0 * turn->Z();
      const double lift = 400.0 * (v.depth - pose->Pos().Z()) - 400.0 * flow->Z();
      hull.AddWorldWrench(
        _ecm,
        ahead * std::clamp(surge, -8000.0, 8000.0) + math::Vector3d(0.0, 0.0, lift),
        math::Vector3d(0.0, 0.0, std::clamp(rudder, -900.0, 900.0)));
    }
  }

  // It follows Physics in one thread: a PostUpdate has a thread of its own, and costs a barrier.
  public: void Update(const UpdateInfo &_info, EntityComponentManager &_ecm) override {
    for (auto &v : this->fleet) {
      const auto pose = Link(v.link).WorldPose(_ecm);
      const auto flow = Link(v.link).WorldLinearVelocity(_ecm);
      if (!pose)
        continue;
      if (!v.isPlaced)
        v.depth = pose->Pos().Z(), v.isPlaced = true;
      else if (!_info.paused)
        v.way += std::hypot(pose->Pos().X() - v.at.X(), pose->Pos().Y() - v.at.Y());
      v.at = pose->Pos();
      v.speed = flow ? std::hypot(flow->X(), flow->Y()) : 0.0;
    }
  }

  private: std::vector<Vehicle> &fleet;
};

int main(int _argc, char **_argv) {
  common::Console::SetVerbosity(1);
  std::vector<Vehicle> fleet;
  for (int i = 3; i < _argc; ++i)
    fleet.push_back(Vehicle{_argv[i]});
  ServerConfig config;
  config.SetSdfFile(_argv[1]);
  Server server(config);
  server.AddSystem(std::make_shared<Helmsman>(fleet));
  server.RunOnce(true);  // paused, for the places only; Run never ends with paused steps
  std::cout << "ready" << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string fly;
    words >> fly;
    for (auto &v : fleet) {
      words >> v.wanted.X() >> v.wanted.Y();
      v.way = 0.0;
    }
    server.Run(true, std::stoul(_argv[2]), false);
    for (const auto &v : fleet)
      std::printf("%.17g %.17g %.17g %.17g %.17g ", v.at.X(), v.at.Y(), v.at.Z(), v.speed, v.way);
    std::printf("0\n");
    std::fflush(stdout);
  }
  return 0;
}
