// Reads a ROS 1 bag by @foxglove/rosbag and prints one line of JSON a message. Numbers that JSON
// lacks are written as text.
//
//     node read_bag.js FOLDER_OF_NODE_MODULES BAG
const path = require("path");

const [folder, bagPath] = process.argv.slice(2);
const load = (name) => require(require.resolve(name, { paths: [path.resolve(folder)] }));
const { Bag } = load("@foxglove/rosbag");
const { FileReader } = load("@foxglove/rosbag/node");
const lz4 = load("@foxglove/wasm-lz4");
const unpackLz4 = lz4.default ?? lz4;
const Bzip2 = load("@foxglove/wasm-bz2");

function plain(key, value) {
  if (ArrayBuffer.isView(value)) return Array.from(value);
  if (typeof value === "bigint") return value.toString();
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  return value;
}

async function main() {
  await unpackLz4.isLoaded;
  const bzip2 = await Bzip2.init();
  const bag = new Bag(new FileReader(bagPath), {
    decompress: {
      lz4: (bytes, size) => unpackLz4(bytes, size),
      bz2: (bytes, size) => bzip2.decompress(bytes, size, { small: false }),
    },
  });
  await bag.open();
  const types = {};
  for (const connection of bag.connections.values()) types[connection.topic] = connection.type;
  for await (const { topic, timestamp, message } of bag.messageIterator()) {
    const line = { topic, type: types[topic], timestamp, message };
    process.stdout.write(JSON.stringify(line, plain) + "\n");
  }
}

main().catch((error) => {
  console.error(error.stack);
  process.exit(1);
});
