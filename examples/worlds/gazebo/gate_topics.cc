// A gate (gates.py) to a Gazebo in another process, over its own topics.
//
//   gate_topics WORLD.sdf STEPS NAME...
//
// It publishes /model/NAME/cmd_vel, steps by /world/mission/control, and hears /model/NAME/odometry.
// VelocityControl turns a cmd_vel with its vehicle, which contact with an obstacle may have turned.
//
// It takes a cmd_vel at the end of a step, and obeys it in the next: from the second of a tick on.
// Odometry may come before that end; the clock shows the same time again after it. Gazebo does not
// acknowledge a cmd_vel, but one thread receives these and requests in turn: a request more than
// there are vehicles is answered behind them. A vehicle that ends a tick with its commanded
// velocity, but elsewhere than that velocity leads from the second step on, obeyed too late.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdio>
#include <functional>
#include <iostream>
#include <mutex>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <ignition/msgs.hh>
#include <ignition/transport/Node.hh>

using namespace ignition;
using namespace std::chrono_literals;

struct Vehicle {
  transport::Node::Publisher says;
  math::Pose3d at;
  math::Vector3d wanted, end, flow;  // flow: velocity in the last step
  double stamp{-1.0}, way{0.0};
};

static std::mutex mutex;
static std::condition_variable came;
static double ended{-1.0}, begun{-1.0};  // times of steps, by the clock

static double seconds(const msgs::Time &_time) { return _time.sec() + 1e-9 * _time.nsec(); }

static void hear(Vehicle &_v, const msgs::Odometry &_odometry) {
  std::lock_guard<std::mutex> lock(mutex);
  const auto at = msgs::Convert(_odometry.pose());
  const double stamp = seconds(_odometry.header().stamp());
  const auto way = at.Pos() - _v.at.Pos();
  _v.flow = way / (stamp - _v.stamp);  // that of the message is the mean of ten steps
  _v.way += std::hypot(way.X(), way.Y());
  _v.at = at;
  _v.stamp = stamp;
  came.notify_all();
}

static void tick(const msgs::Clock &_clock) {
  std::lock_guard<std::mutex> lock(mutex);
  const double before = begun;
  begun = seconds(_clock.sim());
  if (begun == before && ended != begun)
    ended = begun, came.notify_all();
}

int main(int _argc, char **_argv) {
  const int steps = std::stoi(_argv[2]);
  std::vector<Vehicle> fleet(_argc - 3);
  transport::Node node;
  node.Subscribe("/world/mission/clock", &tick);
  for (int i = 3; i < _argc; ++i) {
    auto &v = fleet[i - 3];
    const std::string model = std::string("/model/") + _argv[i];
    v.says = node.Advertise<msgs::Twist>(model + "/cmd_vel");
    std::function<void(const msgs::Odometry &)> each = [&v](const auto &_m) { hear(v, _m); };
    node.Subscribe(model + "/odometry", each);
  }
  const auto ask = [&](int _n, unsigned int _patience_ms) {
    msgs::WorldControl control;
    msgs::Boolean answer;
    bool went = false;
    control.set_pause(true);
    control.set_multi_step(_n);
    return node.Request("/world/mission/control", control, _patience_ms, answer, went) && went;
  };
  const auto step = [&](int _n, double _until) {
    if (!ask(_n, 8000))  // only once: it may have stepped although the answer is late
      return false;
    std::unique_lock<std::mutex> lock(mutex);
    const auto is_there = [&](const Vehicle &_v) { return _v.stamp > _until - 1e-6; };
    return came.wait_for(lock, 8s, [&] {
      return ended > _until - 1e-6 && std::all_of(fleet.begin(), fleet.end(), is_there);
    });
  };
  const auto hears = [](const Vehicle &_v) { return _v.says.HasConnections(); };
  const auto deadline = std::chrono::steady_clock::now() + 20s;
  while (!std::all_of(fleet.begin(), fleet.end(), hears) || !ask(0, 500))
    if (std::this_thread::sleep_for(10ms); std::chrono::steady_clock::now() > deadline)
      return std::cerr << "Gazebo took no commands within 20 s; see its output\n", 1;
  // The first step only tells the odometry its time; two more are published, at rest.
  if (!step(3, 3.0 / steps))
    return std::cerr << "Gazebo published no odometry or clock; see its output\n", 1;
  std::cout << "ready" << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    std::istringstream words(line);
    std::string fly;
    words >> fly;
    for (auto &v : fleet) {
      words >> v.wanted.X() >> v.wanted.Y();
      v.end = v.at.Pos() + v.wanted + (v.flow - v.wanted) / steps;
      v.way = 0.0;
      msgs::Twist twist;
      msgs::Set(twist.mutable_linear(), v.at.Rot().RotateVectorReverse(v.wanted));
      v.says.Publish(twist);
    }
    for (std::size_t i = 0; i <= fleet.size() + 1; ++i)
      ask(0, 8000);  // steps nothing
    if (!step(steps, fleet[0].stamp + 1.0))
      return std::cerr << "Gazebo was silent for 8 s\n", 1;
    int late = 0;
    for (const auto &v : fleet) {
      const auto &at = v.at.Pos();
      const double slack = 0.01 * v.wanted.Length() + 1e-6;
      late += v.flow.Distance(v.wanted) < slack && at.Distance(v.end) > slack;
      const double speed = std::hypot(v.flow.X(), v.flow.Y());
      std::printf("%.17g %.17g %.17g %.17g %.17g ", at.X(), at.Y(), at.Z(), speed, v.way);
    }
    std::printf("%d\n", late);
    std::fflush(stdout);
  }
  return 0;
}
