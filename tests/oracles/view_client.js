// Foxglove's own client, held against the live view: view_client.js PORT. Subscribes to all that is
// advertised, and tells as JSON what came once each of the topics named behind the port has spoken.
"use strict";
const { FoxgloveClient } = require("@foxglove/ws-protocol");
const WebSocket = require("ws");

const [port, ...wanted] = process.argv.slice(2);
const seen = { info: null, channels: {}, messages: {}, times: 0, errors: [] };
const topicOf = new Map();
const patience = setTimeout(() => end(1), 60000);

function end(code) {
  clearTimeout(patience);
  console.log(JSON.stringify(seen));
  process.exit(code);
}

const client = new FoxgloveClient({
  ws: new WebSocket(`ws://127.0.0.1:${port}/`, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]),
});
client.on("serverInfo", (info) => (seen.info = info));
client.on("time", () => seen.times++);
client.on("error", (error) => seen.errors.push(String(error.message ?? error)));
client.on("close", () => end(1));
client.on("advertise", (channels) => {
  for (const channel of channels) {
    seen.channels[channel.topic] = { ...channel, schema: channel.schema.length };
    topicOf.set(client.subscribe(channel.id), channel.topic);
  }
});
client.on("message", ({ subscriptionId, timestamp, data }) => {
  seen.messages[topicOf.get(subscriptionId)] = {
    seconds: Number(timestamp / 1000000000n),
    bytes: data.byteLength,
  };
  if (seen.times > 0 && wanted.every((topic) => topic in seen.messages)) end(0);
});
