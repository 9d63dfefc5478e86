/** A long list, shown from its newest on: what is left out is counted, and can be had. */
export function newestFirst<T>(all: readonly T[], count: number): { shown: T[]; more: number } {
  const from = Math.max(0, all.length - count);
  return { shown: all.slice(from).reverse(), more: from };
}

/** .. in its own order, from the beginning. */
export const firstOf = <T>(all: readonly T[], count: number): { shown: T[]; more: number } => ({
  shown: all.slice(0, count),
  more: Math.max(0, all.length - count),
});
