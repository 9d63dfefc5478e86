/** What of the 3D view other parts of the page may change. */
import { signal } from '@preact/signals';
import type { Layers, Preset } from './scene/scene';

export const layers = signal<Layers>({ trail: true, reach: false, bodies: false, objects: true });
/** A joint whose range is shown. */
export const hoveredJoint = signal<number | null>(null);
/** The joint that a procedure asks about or moves. */
export const meantJoint = signal<{ robot: string; joint: number } | null>(null);
/** A wish to look from somewhere; each is a new object. */
export const look = signal<{ preset: Preset; all: boolean }>({ preset: 'iso', all: true });
