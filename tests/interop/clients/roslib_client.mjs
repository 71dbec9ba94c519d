// What roslib, the JavaScript client, does against a rosbridge server of ROS 1 or 2: one JSON object
// on standard output, one entry per step. Run `node roslib_client.mjs URL ROS`.

import * as ROSLIB from "roslib";

const [url, ros] = process.argv.slice(2);
const isRos2 = ros === "2";
const ADD = isRos2 ? "example_interfaces/srv/AddTwoInts" : "rospy_tutorials/AddTwoInts";
const POSE = isRos2 ? "geometry_msgs/msg/Pose" : "geometry_msgs/Pose";
const STAMP = isRos2 ? { sec: 7, nanosec: 8 } : { secs: 7, nsecs: 8 };
const AT_ONCE = isRos2 ? 10 : 200; // messages of a topic under way; ROS 2 loses those beyond
const PATIENCE_MS = 10_000;

const within = (promise, what) =>
  Promise.race([
    promise,
    new Promise((_, fail) => setTimeout(() => fail(new Error(`no ${what}`)), PATIENCE_MS).unref()),
  ]);

const connected = () => {
  const ros = new ROSLIB.Ros();
  const opened = new Promise((done, fail) => {
    ros.once("connection", () => done(ros));
    ros.once("error", (error) => fail(new Error(`no connection: ${error.message}`)));
  });
  ros.connect(url);
  return within(opened, "connection");
};

const asked = (ros, method, ...names) =>
  within(
    new Promise((done, fail) => ros[method](...names, done, (error) => fail(new Error(error)))),
    method,
  );

const called = (service, request) =>
  within(
    new Promise((done) =>
      service.callService(
        request,
        (values) => done({ values }),
        (error) => done({ error }),
      ),
    ),
    `answer of ${service.name}`,
  );

const received = (topic, count, messages = []) =>
  within(
    new Promise((done) =>
      topic.subscribe((message) => {
        messages.push(message);
        if (messages.length === count) done(messages);
      }),
    ),
    `${count} messages of ${topic.name}`,
  );

const grown = (messages, count) =>
  within(
    new Promise((done) => {
      const look = () => (messages.length >= count ? done() : setTimeout(look, 1));
      look();
    }),
    `${count} messages`,
  );

// A call that is answered was carried out after everything that was sent before it.
const settled = (ros) => asked(ros, "getNodes");

async function topics(a, b) {
  const subscriber = new ROSLIB.Topic({ ros: b, name: "/js/n", messageType: "std_msgs/Int64" });
  const publisher = new ROSLIB.Topic({ ros: a, name: "/js/n", messageType: "std_msgs/msg/Int64" });
  publisher.advertise();
  const messages = [];
  const arriving = received(subscriber, 200, messages);
  await settled(b);
  for (let data = 0; data < 200; data += 1) {
    if (data % AT_ONCE === 0) await grown(messages, data);
    publisher.publish({ data });
  }
  const numbers = (await arriving).map((message) => message.data);
  subscriber.unsubscribe();
  await settled(b);
  let late = 0;
  subscriber.on("message", () => (late += 1));
  publisher.publish({ data: -1 });
  await settled(a);
  await settled(b);
  publisher.unadvertise();
  return { numbers, late };
}

async function latched(a, b) {
  const options = { name: "/js/latched", messageType: "geometry_msgs/Point" };
  const publisher = new ROSLIB.Topic({ ...options, ros: a, latch: true });
  publisher.publish({ x: 1.5 });
  await settled(a);
  return (await received(new ROSLIB.Topic({ ...options, ros: b }), 1))[0];
}

async function png(a, b) {
  const options = { name: "/js/png", messageType: "std_msgs/String" };
  const arriving = received(new ROSLIB.Topic({ ...options, ros: b, compression: "png" }), 1);
  await settled(b);
  new ROSLIB.Topic({ ...options, ros: a }).publish({ data: "é".repeat(1000) });
  return (await arriving)[0].data.length;
}

// On Node, roslib leaves binary frames to its socket, which must be told to give what browsers do.
async function cbor(a, b) {
  b.transport.socket.binaryType = "arraybuffer";
  const options = { name: "/js/joints", messageType: "sensor_msgs/JointState" };
  const arriving = received(new ROSLIB.Topic({ ...options, ros: b, compression: "cbor" }), 1);
  await settled(b);
  const message = { name: ["a"], position: [1, 2.5], header: { stamp: STAMP } };
  new ROSLIB.Topic({ ...options, ros: a }).publish(message);
  const { name, position, header } = (await arriving)[0];
  return { name, kind: position.constructor.name, position: [...position], stamp: header.stamp };
}

// ROS 1 numbers headers, and ROS 2 knows no number: it drops the whole message.
async function headers(a, b) {
  const options = { name: "/js/stamped", messageType: "geometry_msgs/PointStamped" };
  const messages = [];
  const subscriber = new ROSLIB.Topic({ ...options, ros: b });
  subscriber.subscribe((message) => messages.push(message));
  await settled(b);
  const publisher = new ROSLIB.Topic({ ...options, ros: a });
  publisher.publish({ header: { seq: 5, stamp: STAMP }, point: { x: 1 } });
  publisher.publish({ header: { frame_id: "map", stamp: STAMP }, point: { x: 2 } });
  await settled(a);
  await settled(b);
  return messages.map((message) => [message.point.x, message.header]);
}

async function services(a, b) {
  const provider = new ROSLIB.Service({ ros: a, name: "/js/add", serviceType: ADD });
  const caller = new ROSLIB.Service({ ros: b, name: "/js/add", serviceType: ADD });
  const unknown = await called(caller, { a: 2, b: 40 });
  await provider.advertise((request, response) => {
    response.sum = request.a + request.b;
    return request.a >= 0;
  });
  await settled(a);
  const sum = await called(caller, { a: 2, b: 40 });
  const failed = await called(caller, { a: -1, b: 0 });
  const wrong = await called(caller, { c: 1 });
  await provider.unadvertise();
  await provider.advertiseAsync(async (request) => {
    if (request.a < 0) throw new Error("on purpose");
    return { sum: request.a };
  });
  await settled(a);
  const later = await called(caller, { a: 7 });
  const rejected = await called(caller, { a: -1 });
  await provider.unadvertise();
  await settled(a);
  const gone = await called(caller, { a: 1 });
  return { unknown, sum, failed, wrong, later, rejected, gone };
}

async function parameters(a, b) {
  const name = isRos2 ? "js:limits" : "js/limits";
  const value = isRos2 ? [2.5, 3] : { speed: 2.5, names: ["a", "b"] };
  const mine = new ROSLIB.Param({ ros: a, name });
  const theirs = new ROSLIB.Param({ ros: b, name });
  const missing = await asked(theirs, "get");
  await asked(mine, "set", value);
  const kept = await asked(theirs, "get");
  const names = await asked(b, "getParams");
  await asked(mine, "delete");
  return { missing, kept, names, deleted: await asked(theirs, "get") };
}

async function introspection(a, b) {
  const topic = new ROSLIB.Topic({ ros: a, name: "/js/pose", messageType: POSE });
  topic.advertise();
  await settled(a);
  const details = await asked(b, "getMessageDetails", POSE);
  return {
    topics: (await asked(b, "getTopics")).topics,
    type: await asked(b, "getTopicType", "/js/pose"),
    of_type: await asked(b, "getTopicsForType", POSE),
    of_short_type: await asked(b, "getTopicsForType", "geometry_msgs/Pose"),
    raw: (await asked(b, "getTopicsAndRawTypes")).typedefs_full_text.length,
    services: await asked(b, "getServices"),
    service_type: await asked(b, "getServiceType", "/rosapi/topics"),
    request: (await asked(b, "getServiceRequestDetails", ADD)).typedefs[0].fieldnames,
    response: (await asked(b, "getServiceResponseDetails", ADD)).typedefs[0].fieldnames,
    nodes: await asked(b, "getNodes"),
    publishers: await asked(topic, "getPublishers"),
    decoded: b.decodeTypeDefs(details),
    actions: await asked(b, "getActionServers"),
  };
}

async function action(a, b) {
  const options = { serverName: "/js/act", actionName: "actionlib/TestAction" };
  const server = new ROSLIB.SimpleActionServer({ ...options, ros: a });
  server.on("goal", (goal) => server.setSucceeded({ result: goal.goal * 2 }));
  await settled(a);
  const client = new ROSLIB.ActionClient({ ...options, ros: b });
  const goal = new ROSLIB.Goal({ actionClient: client, goalMessage: { goal: 21 } });
  const result = new Promise((done) => goal.on("result", done));
  await settled(b);
  goal.send();
  return within(result, "result of the action");
}

// How a goal ended, and what was heard of it before; `begun` is told its id once there was feedback.
const ended = (client, goal, begun = () => {}) => {
  const feedback = [];
  return within(
    new Promise((done) => {
      const id = client.sendGoal(
        goal,
        (result) => done({ result, feedback }),
        (part) => {
          feedback.push(part.sequence);
          begun(id);
        },
        (error) => done({ error, feedback }),
      );
    }),
    `end of a goal of ${client.name}`,
  );
};

// The provider fails at order -1, ends -2 with a status that is no end, answers 0 with what is no
// result and those below 5 with one, and works on the others until they are cancelled.
const provide = (provider) => {
  const cancelled = [];
  provider.advertise(
    ({ order }, id) => {
      provider.sendFeedback(id, { sequence: [order] });
      const { ros, name: action } = provider;
      const vague = { op: "action_result", id, action, values: { sequence: [2] }, result: true };
      if (order === -1) provider.setFailed(id);
      else if (order === -2) ros.callOnConnection({ ...vague, status: 2 });
      else if (order === 0) provider.setSucceeded(id, { numbers: [] });
      else if (order < 5) provider.setSucceeded(id, { sequence: [order, order] });
    },
    (id) => {
      cancelled.push(id);
      provider.setCanceled(id, { sequence: [5] });
    },
  );
  return cancelled;
};

async function actions(a, b) {
  const options = { name: "/js/count", actionType: "example_interfaces/action/Fibonacci" };
  const client = new ROSLIB.Action({ ...options, ros: b });
  const unknown = await ended(client, { order: 1 });
  const provider = new ROSLIB.Action({ ...options, ros: a });
  const cancelled = provide(provider);
  await settled(a);
  const servers = await asked(b, "getActionServers");
  const counted = await Promise.all([3, 4].map((order) => ended(client, { order })));
  const failed = await ended(client, { order: -1 });
  const vague = await ended(client, { order: -2 });
  const wrong = await ended(client, { orders: 1 });
  const misfit = await ended(client, { order: 0 });
  const given_up = await ended(client, { order: 5 }, (id) => client.cancelGoal(id));
  let begun = 0;
  const cancel = () => ++begun === 2 && client.cancelAllGoals();
  const all_given_up = await Promise.all([8, 9].map((order) => ended(client, { order }, cancel)));
  const unadvertised = await ended(client, { order: 6 }, () => provider.unadvertise());
  const gone = await ended(client, { order: 1 });
  const c = await connected();
  provide(new ROSLIB.Action({ ...options, ros: c }));
  await settled(c);
  const left = await ended(client, { order: 7 }, () => c.close());
  return {
    unknown,
    servers,
    counted,
    failed,
    vague,
    wrong,
    misfit,
    given_up,
    all_given_up,
    n_cancelled: cancelled.length,
    unadvertised,
    gone,
    left,
    servers_left: await asked(b, "getActionServers"),
  };
}

const common = { topics, latched, png, cbor, headers, services, parameters, introspection };
const steps = { ...common, ...(isRos2 ? { actions } : { action }) };
const [a, b] = [await connected(), await connected()];
const report = {};
for (const [name, step] of Object.entries(steps)) {
  try {
    report[name] = await step(a, b);
  } catch (error) {
    report[name] = { broken: String(error) };
  }
}
console.log(JSON.stringify(report));
process.exit(0); // the action server of roslib publishes its status for ever
