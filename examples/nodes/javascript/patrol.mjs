// Drives three huskies round a yard, past silos and each other: `node patrol.mjs URL`.

import { Ros, Topic } from "roslib";

const ROUTES = {
  husky1: [[-40, -20], [-30, 30]],
  husky2: [[40, -20], [-25, -35], [20, 35]],
  husky3: [[20, 10], [0, 40], [-25, -30]],
};
const SILOS = [{ x: 0, y: 0, radius: 10 }, { x: -15, y: 25, radius: 5 }]; // metres
const RADIUS = 1;
const ROOM = 8; // metres that we like to have between two hulls
const ARRIVED = 4;
const CRUISE = 1.2; // metres a second
const CRAWL = 0.6; // on a low battery
const LOW = 0.3; // of a charge
const TOP_TURN = 0.7; // radians a second

const ros = new Ros();
ros.on("error", (error) => {
  console.error(String(error?.message ?? error));
  process.exit(1);
});
ros.on("close", () => process.exit(0));

const huskies = new Map(
  Object.entries(ROUTES).map(([name, route]) => [name, { name, route, leg: 0, charge: 1 }]),
);

const listen = (name, messageType, callback) =>
  new Topic({ ros, name, messageType }).subscribe(callback);

const clamp = (value, limit) => Math.max(-limit, Math.min(limit, value));

// All that a husky could hit, as discs.
function* around(husky) {
  yield* SILOS;
  for (const other of huskies.values()) {
    if (other !== husky && other.pose) yield { ...other.pose, radius: RADIUS };
  }
}

// Where a husky has to turn: towards its next way-point, off what is near, then right of it.
function bearing(husky) {
  const { x, y } = husky.pose;
  let [goalX, goalY] = husky.route[husky.leg];
  if (Math.hypot(goalX - x, goalY - y) < ARRIVED) {
    husky.leg = (husky.leg + 1) % husky.route.length;
    [goalX, goalY] = husky.route[husky.leg];
  }
  const length = Math.hypot(goalX - x, goalY - y);
  let [toX, toY] = [(goalX - x) / length, (goalY - y) / length];
  for (const { x: otherX, y: otherY, radius } of around(husky)) {
    const [offX, offY] = [x - otherX, y - otherY];
    const distance = Math.max(Math.hypot(offX, offY), 0.001);
    const push = (2 * Math.max(0, 1 - (distance - radius - RADIUS) / ROOM)) / distance;
    toX += push * (offX - offY);
    toY += push * (offY + offX);
  }
  return Math.atan2(toY, toX);
}

// The velocity with which a husky answers its pose.
function steer(husky) {
  const error = bearing(husky) - husky.pose.yaw;
  const nearest = Math.atan2(Math.sin(error), Math.cos(error));
  const turn = clamp(nearest, TOP_TURN);
  const speed = (husky.charge > LOW ? CRUISE : CRAWL) * Math.max(0.1, Math.cos(nearest - turn));
  return { linear: { x: speed, y: 0, z: 0 }, angular: { x: 0, y: 0, z: turn } };
}

ros.on("connection", () => {
  for (const husky of huskies.values()) {
    const drive = new Topic({
      ros,
      name: `/${husky.name}/cmd_vel`,
      messageType: "geometry_msgs/Twist",
    });
    drive.advertise();
    listen(`/${husky.name}/battery`, "sensor_msgs/BatteryState", (message) => {
      husky.charge = message.percentage;
    });
    listen(`/${husky.name}/pose`, "geometry_msgs/PoseStamped", ({ pose }) => {
      const { x, y } = pose.position;
      const yaw = 2 * Math.atan2(pose.orientation.z, pose.orientation.w);
      husky.pose = { x, y, yaw };
      drive.publish(steer(husky));
    });
  }
});
ros.connect(process.argv[2]);
