import type { JSX } from 'preact';
import { sketch, type Dot } from '../logic/thumbnail';
import type { Pose, RobotModel } from '../logic/types';

const kSize = 64;
const path = (line: Dot[]): string => line.map(([x, y], i) => `${i ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`).join('');

/** A pose from the side, and small beside it from above. */
export function Thumbnail(props: { model: RobotModel; joints: readonly number[]; platform?: Pose }): JSX.Element {
  const { side, top, sideTool, topTool, floor, topOrigin } = sketch(props.model, props.joints, props.platform, kSize);
  const platform = props.model.kind === 'hexapod';
  return (
    <svg class="thumb" width="108" height="64" viewBox="0 0 108 64" aria-hidden="true" focusable="false">
      <path class="thumb-floor" d={`M2 ${floor.toFixed(1)}H62`} />
      {side.map((line, i) => (
        <path key={i} class={platform && i > 1 ? 'thumb-leg' : 'thumb-arm'} d={path(line)} />
      ))}
      {!platform && side[0]!.map(([x, y], i) => <circle key={i} class="thumb-joint" cx={x} cy={y} r="1.7" />)}
      <circle class="thumb-tool" cx={sideTool[0]} cy={sideTool[1]} r="2.8" />
      <g transform="translate(68 14) scale(.58)">
        <rect class="thumb-plan" x="-2" y="-2" width="68" height="68" rx="8" />
        {top.slice(0, platform ? 2 : 1).map((line, i) => (
          <path key={i} class="thumb-arm" d={path(line)} />
        ))}
        <circle class="thumb-joint" cx={topOrigin[0]} cy={topOrigin[1]} r="2.4" />
        <circle class="thumb-tool" cx={topTool[0]} cy={topTool[1]} r="4.2" />
      </g>
    </svg>
  );
}
