/** Hands the browser a file, which it puts where its person keeps downloads. */
export function handOver(file: string, content: string | Uint8Array<ArrayBuffer>[], type = 'text/plain;charset=utf-8'): void {
  const url = URL.createObjectURL(new Blob(typeof content === 'string' ? [content] : content, { type }));
  const link = Object.assign(document.createElement('a'), { href: url, download: file });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
