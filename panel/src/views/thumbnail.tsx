import type { JSX } from 'preact';
import type { Point } from '../logic/points';
import { platformAt, sketch, sketchPlace, type Dot } from '../logic/thumbnail';
import type { Pose, RobotModel } from '../logic/types';
import { outline } from '../scene/reach';

const kSize = 64;
const path = (line: Dot[]): string => line.map(([x, y], i) => `${i ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`).join('');

/** A point from the side, and small beside it from above; of a place alone what is reached, and the tool. */
export function Thumbnail(props: {
  model: RobotModel;
  joints?: readonly number[];
  platform?: Pose;
  place?: Point['place'];
}): JSX.Element | null {
  const { model, joints, place } = props;
  if (joints) return <PoseThumbnail model={model} joints={joints} platform={props.platform} />;
  if (!place) return null;
  // A platform's pose is all that its legs need.
  if (model.kind === 'hexapod') return <PoseThumbnail model={model} joints={[]} platform={platformAt(model, place)} />;
  return <PlaceThumbnail model={model} place={place} />;
}

function PoseThumbnail(props: { model: RobotModel; joints: readonly number[]; platform?: Pose }): JSX.Element {
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

/** Sampled once a robot. */
const reaches = new WeakMap<RobotModel, Dot[][]>();

function reachOf(model: RobotModel): Dot[][] {
  const known = reaches.get(model);
  if (known) return known;
  const { rim, hole } = outline(model);
  const lines = hole ? [rim, hole] : [rim];
  reaches.set(model, lines);
  return lines;
}

function PlaceThumbnail({ model, place }: { model: RobotModel; place: NonNullable<Point['place']> }): JSX.Element {
  const all = sketchPlace(model, place, reachOf(model), kSize);
  const { sideTool, topTool, topOrigin } = all;
  return (
    <svg class="thumb" width="108" height="64" viewBox="0 0 108 64" aria-hidden="true" focusable="false">
      <path class="thumb-floor" d={`M2 ${all.floor.toFixed(1)}H62`} />
      {all.sideReach.map((line, i) => (
        <path key={i} class="thumb-floor" d={path(line)} />
      ))}
      <path class="thumb-arm" d={path(all.sideBase)} />
      {all.sideWay && <path class="thumb-arm" d={path(all.sideWay)} />}
      <circle class="thumb-tool" cx={sideTool[0]} cy={sideTool[1]} r="2.8" />
      <g transform="translate(68 14) scale(.58)">
        <rect class="thumb-plan" x="-2" y="-2" width="68" height="68" rx="8" />
        <path class="thumb-floor" d={path(all.topReach)} />
        {all.topWay && <path class="thumb-arm" d={path(all.topWay)} />}
        <circle class="thumb-joint" cx={topOrigin[0]} cy={topOrigin[1]} r="2.4" />
        <circle class="thumb-tool" cx={topTool[0]} cy={topTool[1]} r="4.2" />
      </g>
    </svg>
  );
}
