/** The controller's records: what there is, and their bytes part by part. */
import type { Caller } from './store';
import { decimals } from './units';

export interface KeptRecord {
  record: string;
  size_bytes: number;
  fault: boolean;
  robot?: string;
  title?: string;
  began_ms?: number;
  length_s?: number;
  under_way?: boolean;
}
export interface KeptRecords {
  folder: string;
  records: KeptRecord[];
}

interface Part {
  data: string;
  offset: number;
  size_bytes: number;
  end: boolean;
}

export function bytesOf(base64: string): Uint8Array<ArrayBuffer> {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}

export type RecordForm = 'mcap' | 'csv';

/**
 * @param told   share that is there, 0 to 1
 * @param goes   false: nobody wants it any more
 */
export async function fetchRecord(
  rpc: Caller,
  record: string,
  form: RecordForm,
  told: (share: number) => void = () => undefined,
  goes: () => boolean = () => true,
): Promise<Uint8Array<ArrayBuffer>[] | null> {
  const parts: Uint8Array<ArrayBuffer>[] = [];
  for (let offset = 0; goes(); ) {
    const part = await rpc.call<Part>(form === 'csv' ? 'records.csv' : 'records.read', { record, offset }, 60_000);
    const bytes = bytesOf(part.data);
    parts.push(bytes);
    offset += bytes.length;
    told(part.size_bytes > 0 ? Math.min(1, offset / part.size_bytes) : 1);
    // One that is being written may grow for ever.
    if (part.end || bytes.length === 0) return parts;
  }
  return null;
}

/** "1.2 MB", "340 kB". */
export function sizeText(bytes: number): string {
  if (bytes < 1e6) return `${Math.max(1, Math.round(bytes / 1e3))} kB`;
  return `${decimals(bytes / 1e6, bytes < 1e8 ? 1 : 0)} MB`;
}
