// Stands for Gazebo's server in tests: its topics and its service, with points in place of bodies.
//
//   gazebo_standin [--deaf N | --yaw ANGLE] WORLD.sdf
//
// As Gazebo does, it answers the control service before it steps, obeys commands from the second
// step on, publishes odometry from the second step on, and its clock at each step and while it is
// paused. With --deaf it obeys commands from step N + 1 on. With --yaw its bodies are turned, and the
// commands with them.
#include <chrono>
#include <condition_variable>
#include <fstream>
#include <iostream>
#include <map>
#include <mutex>
#include <regex>
#include <sstream>
#include <string>
#include <thread>

#include <ignition/msgs.hh>
#include <ignition/transport/Node.hh>

using namespace ignition;

struct Body {
  transport::Node::Publisher says;
  math::Vector3d at, told, flow;
};

static std::map<std::string, Body> bodies;
static std::mutex mutex;
static std::condition_variable asked;
static int wanted = 0;

static bool control(const msgs::WorldControl &_control, msgs::Boolean &_answer) {
  std::lock_guard<std::mutex> lock(mutex);
  wanted += static_cast<int>(_control.multi_step());
  _answer.set_data(true);
  asked.notify_all();
  return true;
}

int main(int _argc, char **_argv) {
  const std::string option = _argc > 2 ? _argv[1] : "";
  const int deaf = option == "--deaf" ? std::stoi(_argv[2]) : 1;
  const math::Quaterniond turned(0.0, 0.0, option == "--yaw" ? std::stod(_argv[2]) : 0.0);
  std::ifstream file(_argv[_argc - 1]);
  const std::string sdf((std::istreambuf_iterator<char>(file)), {});
  transport::Node node;
  const std::regex model("<model name=\"([^\"]+)\">\\s*<pose>(\\S+) (\\S+) (\\S+) 0 0 0</pose>");
  for (std::sregex_iterator each(sdf.begin(), sdf.end(), model), end; each != end; ++each) {
    const std::string name = (*each)[1];
    auto &body = bodies[name];
    body.at.Set(std::stod((*each)[2]), std::stod((*each)[3]), std::stod((*each)[4]));
    body.says = node.Advertise<msgs::Odometry>("/model/" + name + "/odometry");
    std::function<void(const msgs::Twist &)> hear = [&body](const auto &_twist) {
      std::lock_guard<std::mutex> lock(mutex);
      body.told = msgs::Convert(_twist.linear());
    };
    node.Subscribe("/model/" + name + "/cmd_vel", hear);
  }
  std::smatch found;
  std::regex_search(sdf, found, std::regex("<max_step_size>(\\S+)</max_step_size>"));
  const double step = std::stod(found[1]);
  node.Advertise("/world/mission/control", &control);
  auto clock = node.Advertise<msgs::Clock>("/world/mission/clock");
  msgs::Clock now;
  for (long n = 1, since = 0; true; ++n) {
    std::unique_lock<std::mutex> lock(mutex);
    since = wanted ? since + 1 : 0;
    while (!asked.wait_for(lock, std::chrono::milliseconds(1), [] { return wanted > 0; }))
      clock.Publish(now);
    --wanted;
    const auto time = std::chrono::round<std::chrono::nanoseconds>(
        n * std::chrono::duration<double>(step));
    now.mutable_sim()->set_sec(time.count() / 1000000000);
    now.mutable_sim()->set_nsec(time.count() % 1000000000);
    clock.Publish(now);
    for (auto &[name, body] : bodies) {
      if (since >= deaf)
        body.flow = turned.RotateVector(body.told);
      body.at += body.flow * step;
      if (n == 1)
        continue;
      msgs::Odometry odometry;
      *odometry.mutable_header()->mutable_stamp() = now.sim();
      msgs::Set(odometry.mutable_pose(), math::Pose3d(body.at, turned));
      body.says.Publish(odometry);
    }
  }
}
