import type { RobotStatus } from './types';

/// A robot that is ready, for tests.
export const ready: RobotStatus = {
  robot: 'arm',
  at_s: 0,
  state: 'ready',
  position: 'measured',
  connected: true,
  joints: [],
  feed: 1,
  free_drive: false,
  progress: 0,
  health: {},
};
