/** What the calibration wizard knows of printed sheets and of figures. */

/** Tags of the sheet for the table; all others are the board's. */
export const kSheetTags: ReadonlySet<number> = new Set([580, 581, 582, 583]);

/** How far a view's residual reaches on its bar, 0 to 1. Above 1 px rms a view is poor. */
export const residualShare = (px: number): number => Math.min(1, px / 1.333);
