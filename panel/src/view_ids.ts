/** The views of the right side, in their order; the first one opens first. `views.tsx` has them. */
export const kViewIds = ['jog', 'move', 'programs', 'camera', 'setup', 'plots', 'device', 'events', 'help'] as const;
export type ViewId = (typeof kViewIds)[number];
