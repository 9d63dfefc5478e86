/**
 * Reads the MCAP files that this project writes (https://mcap.dev/spec, version 0): chunks that are
 * not compressed, checksums checked. A file that was cut off gives what stands in front of the cut;
 * a damaged one is refused, with the byte where it begins. The file is somebody's: every length is
 * held against what is there before it is believed.
 */

export interface McapChannel {
  id: number;
  topic: string;
  schema: string;
  encoding: string;
}

export interface McapMessage {
  channel: number;
  /** ns */
  time: bigint;
  data: Uint8Array;
}

export interface McapFile {
  library: string;
  channels: Map<number, McapChannel>;
  messages: McapMessage[];
  metadata: Record<string, Record<string, string>>;
  /** It has its end; else it was cut off. */
  whole: boolean;
}

export class McapError extends Error {
  constructor(
    readonly what: 'magic' | 'compressed' | 'checksum' | 'damaged' | 'empty',
    readonly at: number,
  ) {
    super(`${what} at byte ${at}`);
  }
}

const kMagic = [0x89, 0x4d, 0x43, 0x41, 0x50, 0x30, 0x0d, 0x0a];
const kRecordHead = 9;
const enum Op {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMetadata = 12,
  kDataEnd = 15,
}

const kCrcTable = Uint32Array.from({ length: 256 }, (_, n) => {
  let c = n;
  for (let k = 0; k < 8; ++k) c = c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1;
  return c >>> 0;
});

/** Of Ethernet and zlib; "123456789" gives CBF43926. */
export function crc32(bytes: Uint8Array): number {
  let c = 0xffffffff;
  for (let i = 0; i < bytes.length; ++i) c = kCrcTable[(c ^ bytes[i]!) & 0xff]! ^ (c >>> 8);
  return (c ^ 0xffffffff) >>> 0;
}

/** Numbers and texts of one record; never behind its end. */
class Cursor {
  private readonly view: DataView;
  at = 0;
  constructor(
    private readonly bytes: Uint8Array,
    private readonly base: number,
  ) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }
  private take(count: number): number {
    if (!(count <= this.bytes.length - this.at)) throw new McapError('damaged', this.base + this.at);
    const from = this.at;
    this.at += count;
    return from;
  }
  u16 = (): number => this.view.getUint16(this.take(2), true);
  u32 = (): number => this.view.getUint32(this.take(4), true);
  u64 = (): bigint => this.view.getBigUint64(this.take(8), true);
  length = (): number => Number(this.u64());
  raw = (count: number): Uint8Array => {
    const from = this.take(count);
    return this.bytes.subarray(from, from + count);
  };
  text = (): string => new TextDecoder().decode(this.raw(this.u32()));
  pairs = (): Record<string, string> => {
    const end = this.u32() + this.at;
    const map: Record<string, string> = {};
    while (this.at < end) {
      const key = this.text();
      Object.defineProperty(map, key, { value: this.text(), enumerable: true, configurable: true });
    }
    return map;
  };
  rest = (): Uint8Array => this.raw(this.bytes.length - this.at);
}

export function readMcap(bytes: Uint8Array): McapFile {
  if (bytes.length < kMagic.length || kMagic.some((one, i) => bytes[i] !== one)) throw new McapError('magic', 0);
  const file: McapFile = { library: '', channels: new Map(), messages: [], metadata: {}, whole: false };
  const schemas = new Map<number, string>();
  readRecords(bytes, kMagic.length, file, schemas, true);
  if (file.channels.size === 0) throw new McapError('empty', kMagic.length);
  return file;
}

/** @param cut  an end in the middle of a record is the file's end; else it is damage */
function readRecords(
  bytes: Uint8Array,
  from: number,
  file: McapFile,
  schemas: Map<number, string>,
  cut: boolean,
  base = 0,
): void {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  for (let at = from; at < bytes.length; ) {
    if (bytes.length - at < kRecordHead) {
      if (cut) return;
      throw new McapError('damaged', base + at);
    }
    const op = bytes[at]!;
    const length = Number(view.getBigUint64(at + 1, true));
    const begin = at + kRecordHead;
    if (length > bytes.length - begin) {
      if (cut) return;
      throw new McapError('damaged', base + at);
    }
    const content = bytes.subarray(begin, begin + length);
    if (readRecord(op, content, base + begin, file, schemas)) return;
    at = begin + length;
  }
}

/** @return  the data's end was reached */
function readRecord(
  op: number,
  content: Uint8Array,
  at: number,
  file: McapFile,
  schemas: Map<number, string>,
): boolean {
  const in_ = new Cursor(content, at);
  switch (op) {
    case Op.kHeader:
      in_.text();
      file.library = in_.text();
      return false;
    case Op.kSchema:
      schemas.set(in_.u16(), in_.text());
      return false;
    case Op.kChannel: {
      const id = in_.u16();
      const schema = schemas.get(in_.u16()) ?? '';
      file.channels.set(id, { id, schema, topic: in_.text(), encoding: in_.text() });
      return false;
    }
    case Op.kMessage: {
      const channel = in_.u16();
      in_.u32();
      const time = in_.u64();
      in_.u64();
      file.messages.push({ channel, time, data: in_.rest() });
      return false;
    }
    case Op.kChunk: {
      in_.u64();
      in_.u64();
      const size = in_.length();
      const crc = in_.u32();
      if (in_.text() !== '') throw new McapError('compressed', at);
      const stored = in_.length();
      const records = in_.raw(stored);
      if (stored !== size) throw new McapError('damaged', at);
      if (crc !== 0 && crc32(records) !== crc) throw new McapError('checksum', at);
      readRecords(records, 0, file, schemas, false, at + in_.at - stored);
      return false;
    }
    case Op.kMetadata: {
      const name = in_.text();
      Object.defineProperty(file.metadata, name, { value: in_.pairs(), enumerable: true, configurable: true });
      return false;
    }
    case Op.kDataEnd:
      file.whole = true;
      return true;
    case Op.kFooter:
      return true;
    default:
      return false;
  }
}
