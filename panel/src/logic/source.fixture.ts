// @ts-expect-error  the page itself has no node; its tests run in one
import { readFileSync } from 'node:fs';

/** A file of the server or of its documents, by its path in the repository: what the panel's tables are held against. */
export const source = (file: string): string => readFileSync(new URL(`../../../${file}`, import.meta.url), 'utf8') as string;
