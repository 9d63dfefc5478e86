/** Every view of the right side; a new one is a row here and a name in view_ids.ts. */
import type { ComponentType } from 'preact';
import type { ViewId } from './view_ids';
import { CameraPane } from './views/camera_pane';
import { DevicePane } from './views/device_pane';
import { EventsPane } from './views/events_pane';
import { HelpPane } from './views/help_pane';
import { JogPane } from './views/jog_pane';
import { MovePane } from './views/move_pane';
import type { IconName } from './views/parts';
import { PlotsPane } from './views/plots_pane';
import { ProgramsPane } from './views/programs_pane';
import { SetupPane } from './views/setup_pane';

export const kViews: Record<ViewId, { icon: IconName; show: ComponentType }> = {
  jog: { icon: 'jog', show: JogPane },
  move: { icon: 'move', show: MovePane },
  programs: { icon: 'programs', show: ProgramsPane },
  camera: { icon: 'eye', show: CameraPane },
  setup: { icon: 'setup', show: SetupPane },
  plots: { icon: 'plots', show: PlotsPane },
  device: { icon: 'device', show: DevicePane },
  events: { icon: 'events', show: EventsPane },
  help: { icon: 'help', show: HelpPane },
};
