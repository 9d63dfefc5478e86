// check_record.mjs FILE [FILE ..]: opens records with the public MCAP reader, as a viewer does, and
// says one line a file, or what is wrong with it.
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { readFile } from "node:fs/promises";

const kTopics = ["joint_states", "state", "events", "wire", "tool"];

function demand(holds, sentence) {
  if (!holds) throw new Error(sentence);
}

/// Every number and text is of the type that the channel's schema promises.
function fits(schema, value, where) {
  if (schema.type === "object") {
    demand(typeof value === "object" && value !== null && !Array.isArray(value), `${where}: no object`);
    for (const [key, inner] of Object.entries(value)) {
      demand(schema.properties?.[key] !== undefined, `${where}.${key} is not in its schema`);
      fits(schema.properties[key], inner, `${where}.${key}`);
    }
    return;
  }
  const type = schema.type === "integer" ? "number" : schema.type;
  demand(typeof value === type, `${where} is no ${schema.type}`);
  demand(schema.type !== "integer" || Number.isInteger(value), `${where} is no integer`);
}

async function indexed(bytes) {
  const reader = await McapIndexedReader.Initialize({
    readable: {
      size: async () => BigInt(bytes.byteLength),
      read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
    },
  });
  const text = new TextDecoder("utf-8", { fatal: true });
  const counts = new Map();
  let before = 0n;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    const schema = reader.schemasById.get(channel.schemaId);
    demand(schema.encoding === "jsonschema" && channel.messageEncoding === "json",
      `${channel.topic} is no JSON with a JSON schema`);
    demand(message.logTime >= before, `${channel.topic}: time runs back`);
    before = message.logTime;
    const number = counts.get(message.channelId) ?? 0;
    demand(message.sequence === number, `${channel.topic}: message ${number} is ${message.sequence}`);
    counts.set(message.channelId, number + 1);
    fits(JSON.parse(text.decode(schema.data)), JSON.parse(text.decode(message.data)), channel.topic);
  }
  for (const [id, count] of counts) {
    demand(reader.statistics.channelMessageCounts.get(id) === BigInt(count),
      `the statistics say another number of messages of channel ${id}`);
  }
  const topics = [...reader.channelsById.values()].map((channel) => channel.topic.split("/").pop());
  demand(kTopics.every((topic) => topics.includes(topic)), `channels are missing: ${topics}`);
  demand((counts.size > 0), "there is no message in it");
  const total = [...counts.values()].reduce((sum, count) => sum + count, 0);
  demand(reader.statistics.messageCount === BigInt(total), "the statistics count otherwise");
  return { total, counts, reader };
}

/// Front to back, as `mcap recover` and a live viewer read, with every chunk's checksum.
function streamed(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(bytes);
  let messages = 0;
  for (let record; (record = reader.nextRecord()); ) messages += record.type === "Message" ? 1 : 0;
  demand(reader.done(), "the file does not end where it says");
  return messages;
}

let failed = process.argv.length < 3;
for (const file of process.argv.slice(2)) {
  try {
    const bytes = new Uint8Array(await readFile(file));
    const { total, counts, reader } = await indexed(bytes);
    demand(streamed(bytes) === total, "read front to back it has another number of messages");
    const parts = [...counts].map(([id, count]) => `${reader.channelsById.get(id).topic} ${count}`);
    console.log(`${file}: fine; ${total} messages, ${reader.chunkIndexes.length} chunks: ${parts.join(", ")}`);
  } catch (error) {
    failed = true;
    console.log(`${file}: ${error.message}`);
  }
}
process.exit(failed ? 1 : 0);
