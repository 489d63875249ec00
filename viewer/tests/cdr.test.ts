import assert from "node:assert/strict";
import { test } from "node:test";
import { CdrReader, DamagedMessage } from "../src/cdr.ts";
import * as messages from "../src/messages.ts";
import { CdrWriter } from "../demo/cdr_writer.ts";
import { Random } from "../demo/random.ts";
import * as wire from "../demo/messages.ts";

test("values come back as they were written, in either order of bytes", () => {
  for (const little of [true, false]) {
    const bytes = new CdrWriter(little)
      .u8(7)
      .f64(Math.PI)
      .string("läser")
      .i32(-5)
      .u8s(Uint8Array.of(1, 2, 3))
      .u32s([1, 4_000_000_000])
      .f32s([0.5, -0.25])
      .f64s([1e300])
      .i32s([-1, 2])
      .done();
    const reader = new CdrReader(bytes);
    assert.equal(reader.u8(), 7);
    assert.equal(reader.f64(), Math.PI);
    assert.equal(reader.string(), "läser");
    assert.equal(reader.i32(), -5);
    assert.deepEqual([...reader.u8s()], [1, 2, 3]);
    assert.deepEqual([...reader.u32s()], [1, 4_000_000_000]);
    assert.deepEqual([...reader.f32s()], [0.5, -0.25]);
    assert.deepEqual([...reader.f64s()], [1e300]);
    assert.deepEqual([...reader.i32s()], [-1, 2]);
    assert.equal(reader.left, 0);
  }
});

test("numbers are aligned after the encapsulation, also in a message that begins anywhere", () => {
  // By hand: u8 1, seven bytes of nothing, f64 2.0.
  const inner = Uint8Array.of(0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40);
  for (let shift = 0; shift < 9; shift++) {
    const outer = new Uint8Array(inner.length + shift);
    outer.set(inner, shift);
    const reader = new CdrReader(outer.subarray(shift));
    assert.equal(reader.u8(), 1);
    assert.equal(reader.f64(), 2);
  }
});

test("an empty list of doubles takes no room for their alignment", () => {
  const bytes = Uint8Array.of(0, 1, 0, 0, 0, 0, 0, 0, 9, 0, 0, 0);
  const reader = new CdrReader(bytes);
  assert.equal(reader.f64s().length, 0);
  assert.equal(reader.u32(), 9);
});

test("a count that the message can't hold is refused before anything is allocated", () => {
  const bytes = Uint8Array.of(0, 1, 0, 0, 255, 255, 255, 255, 0, 0);
  for (const read of ["string", "u8s", "i32s", "u32s", "f32s", "f64s"] as const) {
    assert.throws(() => new CdrReader(bytes)[read](), DamagedMessage);
  }
});

test("tiles", () => {
  const tiles = {
    ids: [-2, 3, 0, 1],
    cells: [new Uint8Array(16).fill(9), new Uint8Array(16).fill(255)],
  };
  const bytes = wire.mapTiles({ resolution: 0.05, size: 4 }, tiles, true);
  const read = messages.readMapTiles(bytes);
  assert.deepEqual([...read.ids], tiles.ids);
  assert.equal(read.size, 4);
  assert.equal(read.resolution, 0.05);
  assert.equal(read.whole, true);
  assert.equal(read.cells.length, 32);
  assert.equal(read.cells[0], 9);
  assert.equal(read.cells[31], 255);
});

test("tiles whose cells do not fit are refused", () => {
  const tiles = { ids: [0, 0, 1, 1], cells: [new Uint8Array(16)] };
  assert.throws(
    () => messages.readMapTiles(wire.mapTiles({ resolution: 0.05, size: 4 }, tiles, true)),
    DamagedMessage,
  );
  for (const [resolution, size] of [
    [0, 4],
    [NaN, 4],
    [0.05, 0],
    [0.05, 100_000],
  ] as const) {
    const bytes = new CdrWriter()
      .f64(resolution)
      .u32(size)
      .u8(0)
      .i32s([])
      .u8s(new Uint8Array(0))
      .done();
    assert.throws(() => messages.readMapTiles(bytes), DamagedMessage);
  }
});

const kNodes = [0, 1, 2].map((i) => ({
  t: 100 + i,
  pose: { x: i, y: -i, yaw: 0.5 },
  sigma: 0.1 * i,
  submap: i,
  drive: i >> 1,
  travelled: i,
}));

test("a trajectory, whole and its tail", () => {
  const read = messages.readTrajectory(wire.trajectory(kNodes, 1, 3));
  assert.equal(read.first, 1);
  assert.equal(read.count, 3);
  assert.deepEqual([...read.t], [101, 102]);
  assert.deepEqual([...read.poses], [1, -1, 0.5, 2, -2, 0.5]);
  assert.deepEqual([...read.drives], [0, 1]);
});

test("messages of ROS", () => {
  const pose = { x: 1, y: 2, yaw: -3 };
  const robot = messages.readPoseWithCovariance(wire.poseWithCovariance(5.25, pose, 0.1));
  assert.equal(robot.header.stamp, 5.25);
  assert.equal(robot.header.frame, "map");
  assert.ok(Math.abs(robot.pose.yaw + 3) < 1e-12);
  assert.ok(Math.abs(robot.covariance[0] - 0.09) < 1e-12);
  const [tf] = messages.readTransforms(wire.transforms(7, [["map", "base_link", pose]]));
  assert.equal(tf?.parent, "map");
  assert.equal(tf?.child, "base_link");
  assert.equal(tf?.pose.x, 1);
  const scan = messages.readLaserScan(wire.laserScan(1, [1, Infinity, 3]));
  assert.equal(scan.header.frame, "laser");
  assert.deepEqual([...scan.ranges], [1, Infinity, 3]);
  assert.deepEqual([...messages.readPoseArray(wire.particles(1, [pose]))].slice(0, 2), [1, 2]);
  const path = new CdrWriter().header(1, "map").u32(1).header(2, "map").pose(3, 4, 0).done();
  assert.deepEqual([...messages.readPath(path).poses], [3, 4, 0]);
  const grid = new CdrWriter()
    .header(1, "map")
    .stamp(0)
    .f32(0.5)
    .u32(2)
    .u32(1)
    .pose(1, 1, 0)
    .u8s(Uint8Array.of(0, 255))
    .done();
  const read = messages.readOccupancyGrid(grid);
  assert.deepEqual([read.width, read.height, read.resolution], [2, 1, 0.5]);
});

const kReaders = [
  messages.readTransforms,
  messages.readLaserScan,
  messages.readPoseWithCovariance,
  messages.readPoseArray,
  messages.readPath,
  messages.readOccupancyGrid,
  messages.readMapTiles,
  messages.readTrajectory,
];

function tryAll(bytes: Uint8Array): void {
  for (const read of kReaders) {
    try {
      read(bytes);
    } catch (error) {
      assert.ok(error instanceof DamagedMessage, String(error));
    }
  }
}

test("whatever bytes come, a message is read or refused, and soon", () => {
  const random = new Random(11);
  const begin = Date.now();
  for (let i = 0; i < 20_000; i++) {
    const bytes = Uint8Array.from({ length: random.integer(200) }, () => random.integer(256));
    if (i % 2 === 0 && bytes.length >= 4) bytes.set([0, 1, 0, 0]);
    tryAll(bytes);
  }
  assert.ok(Date.now() - begin < 20_000);
});

test("good messages that are cut or spoiled are read or refused", () => {
  const random = new Random(12);
  const good = [
    wire.trajectory(kNodes, 0, 3),
    wire.laserScan(1, [1, 2, 3]),
    wire.mapTiles(
      { resolution: 0.05, size: 4 },
      { ids: [0, 0], cells: [new Uint8Array(16)] },
      false,
    ),
    wire.poseWithCovariance(1, { x: 0, y: 0, yaw: 0 }, 0.1),
    wire.transforms(1, [["map", "base_link", { x: 0, y: 0, yaw: 0 }]]),
  ];
  for (const bytes of good) {
    for (let length = 0; length < bytes.length; length++) tryAll(bytes.subarray(0, length));
    for (let i = 0; i < 3000; i++) {
      const spoiled = bytes.slice();
      for (let k = 0; k < 1 + random.integer(4); k++)
        spoiled[random.integer(spoiled.length)] = random.integer(256);
      tryAll(spoiled);
    }
  }
});
