import type { JSX } from 'preact';
import { computed } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { errorSentence, t, tWord } from '../i18n';
import { basket, baskets, chosenBasket, chosenCube, lens } from '../camera_state';
import { paintOf, verdictOf } from '../logic/camera';
import { onPlane, project, type Pixel } from '../logic/lens';
import { add, fromFlat, rotate } from '../logic/pose';
import { outlines, smooth, straightDown, taken, type Place } from '../logic/region';
import type { BasketJson, CameraShot, CubeVerdictJson, SeenCubeJson, Vec3 } from '../logic/types';
import { basketNote, dragged, moveBasket, reach, showsReach, takesCubes, turned, turnOf, verdicts } from '../table_state';
import { decimals } from '../logic/units';
import { Icon, NumberField, Segments, Toggle } from './parts';

const text = (points: readonly Pixel[]): string => points.map((p) => `${p[0].toFixed(1)},${p[1].toFixed(1)}`).join(' ');

/** Why a cube cannot be had, and what would help; nothing where it can, or while that is not known. */
export function whyNot(cube: SeenCubeJson): string | null {
  const verdict = cube.in_basket ? undefined : verdictOf(cube, verdicts.value);
  return verdict && !verdict.fine ? whyText(verdict) : null;
}

function whyText({ error }: CubeVerdictJson): string {
  const key = `cube.help.${error?.code}`;
  const help = error ? tWord('cube.help', error.code) : '';
  const known = help !== '' && help !== key.slice('cube.help.'.length).replaceAll('_', ' ');
  return [error ? errorSentence(error) : '', known ? t('table.to_fix', { help }) : ''].filter(Boolean).join('. ');
}

/** What lies under the cubes' outlines: where cubes can be taken, and the baskets. */
export function TableOverlay({ stroke }: { stroke: number }): JSX.Element | null {
  if (!lens.value) return null;
  return (
    <>
      <Region stroke={stroke} />
      {baskets.value.map((one) => (
        <BasketOutline key={one.name} basket={dragged.value?.name === one.name ? dragged.value : one} stroke={stroke} />
      ))}
    </>
  );
}

function loopPath(loops: readonly Place[][], height: number): string {
  const view = lens.value!;
  return loops
    .map((loop) => smooth(loop).flatMap(([x, y]) => project(view, [x, y, height]) ?? []))
    .filter((flat) => flat.length > 4)
    .map((flat) => {
      let path = '';
      for (let i = 0; i < flat.length; i += 2) path += `${i === 0 ? 'M' : 'L'}${flat[i]!.toFixed(1)} ${flat[i + 1]!.toFixed(1)}`;
      return `${path}Z`;
    })
    .join('');
}

const region = computed(() => {
  const grid = reach.value;
  if (!grid || !lens.value) return null;
  return { taken: loopPath(outlines(grid, taken), grid.z_m), straight: loopPath(outlines(grid, straightDown), grid.z_m) };
});

function Region({ stroke }: { stroke: number }): JSX.Element | null {
  const shown = region.value;
  if (!shown) return null;
  return (
    <g class="camera-region" aria-hidden="true">
      <path d={shown.taken} class="tilted" stroke-width={stroke} />
      <path d={shown.straight} class="straight" stroke-width={stroke} />
    </g>
  );
}

/** Corners of its floor and its rim, in the cell. */
function cornersOf(one: BasketJson): { floor: Vec3[]; rim: Vec3[] } {
  const { p, q } = fromFlat(one);
  const at = (x: number, y: number, z: number): Vec3 => add(p, rotate(q, [x, y, z]));
  const around = (z: number): Vec3[] =>
    ([[-1, -1], [1, -1], [1, 1], [-1, 1]] as const).map(([x, y]) => at((x * one.length_m) / 2, (y * one.width_m) / 2, z));
  return { floor: around(0), rim: around(one.height_m) };
}

function BasketOutline({ basket: one, stroke }: { basket: BasketJson; stroke: number }): JSX.Element | null {
  const from = useRef<{ at: Vec3; basket: BasketJson } | null>(null);
  const view = lens.value!;
  const { floor, rim } = cornersOf(one);
  const places = [...floor, ...rim].map((p) => project(view, p));
  if (places.some((p) => p === null)) return null;
  const [below, above] = [places.slice(0, 4) as Pixel[], places.slice(4) as Pixel[]];
  const middle = project(view, [one.x_m, one.y_m, one.z_m + one.height_m])!;
  const under = (event: PointerEvent): Vec3 | null => {
    const svg = (event.currentTarget as SVGGElement).ownerSVGElement!;
    const p = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM()!.inverse());
    return onPlane(view, [p.x, p.y], one.z_m + one.height_m);
  };
  const end = (event: PointerEvent, moves: boolean) => {
    const begun = from.current;
    from.current = null;
    (event.currentTarget as SVGGElement).releasePointerCapture(event.pointerId);
    if (!begun) return;
    const to = dragged.value;
    if (moves && to && Math.hypot(to.x_m - begun.basket.x_m, to.y_m - begun.basket.y_m) > 1e-3) void moveBasket(to);
    else dragged.value = null;
  };
  return (
    <g
      class={`camera-basket${dragged.value?.name === one.name ? ' dragged' : ''}`}
      data-basket={one.name}
      onPointerDown={(event) => {
        const at = under(event);
        if (!at || event.button !== 0) return;
        event.preventDefault();
        (event.currentTarget as SVGGElement).setPointerCapture(event.pointerId);
        from.current = { at, basket: one };
        chosenBasket.value = one.name;
      }}
      onPointerMove={(event) => {
        const at = from.current && under(event);
        if (!from.current || !at) return;
        const { at: begun, basket: before } = from.current;
        dragged.value = { ...before, x_m: before.x_m + at[0] - begun[0], y_m: before.y_m + at[1] - begun[1] };
      }}
      onPointerUp={(event) => end(event, true)}
      onPointerCancel={(event) => end(event, false)}
    >
      <title>{t('table.basket.drag', { basket: one.name })}</title>
      <polygon class="floor" points={text(below)} stroke-width={0.8 * stroke} />
      {below.map((p, i) => (
        <line key={i} x1={p[0]} y1={p[1]} x2={above[i]![0]} y2={above[i]![1]} stroke-width={0.8 * stroke} />
      ))}
      <polygon class="rim" points={text(above)} stroke-width={1.8 * stroke} />
      <text x={middle[0]} y={middle[1]} font-size={9 * stroke}>
        {one.name}
      </text>
    </g>
  );
}

/** What of the table can be changed and looked up by words and numbers. */
export function TableControls({ now }: { now: CameraShot }): JSX.Element | null {
  if (!lens.value) return null;
  return (
    <>
      <CannotHave cubes={now.cubes ?? []} />
      {takesCubes.value && <ReachSwitch />}
      {basket.value && <BasketPlace />}
    </>
  );
}

function CannotHave({ cubes }: { cubes: SeenCubeJson[] }): JSX.Element | null {
  const out = cubes.flatMap((cube, i) => {
    const why = whyNot(cube);
    return why ? [{ cube, i, why }] : [];
  });
  if (out.length === 0) return null;
  return (
    <section class="camera-cannot" aria-label={t('table.cannot')}>
      <h4>{t('table.cannot')}</h4>
      <ul>
        {out.map(({ cube, i, why }) => (
          <li key={i}>
            <button type="button" class="quiet" aria-current={chosenCube.value === i ? 'true' : undefined} onClick={() => (chosenCube.value = i)}>
              <span class="camera-swatch" style={{ background: paintOf(cube.color) }} aria-hidden="true" />
              {tWord('color', cube.color)}
            </button>
            <span>{why}</span>
          </li>
        ))}
      </ul>
    </section>
  );
}

function ReachSwitch(): JSX.Element {
  const grid = reach.value;
  return (
    <div class="camera-reach">
      <Toggle pressed={showsReach.value} onChange={(on) => (showsReach.value = on)}>
        {t('table.reach')}
      </Toggle>
      {showsReach.value && (
        <p class="hint" role="status">
          <span class="camera-key straight" /> {t('table.reach.straight')} <span class="camera-key tilted" /> {t('table.reach.tilted')}
          <br />
          {grid && grid.done === 1
            ? t('table.reach.of', { edge: decimals(1000 * grid.edge_m, 0) })
            : t('table.reach.under_way', { percent: Math.floor(100 * (grid?.done ?? 0)) })}
        </p>
      )}
    </div>
  );
}

function BasketPlace(): JSX.Element {
  const one = dragged.value ?? basket.value!;
  const place = (to: Partial<BasketJson>) => void moveBasket({ ...one, ...to });
  const note = basketNote.value;
  return (
    <section class="camera-place" aria-label={t('table.basket', { basket: one.name })}>
      {baskets.value.length > 1 ? (
        <Segments
          label={t('table.baskets')}
          value={one.name}
          options={baskets.value.map(({ name }) => ({ value: name, text: name }))}
          onChange={(name) => (chosenBasket.value = name)}
        />
      ) : (
        <h4>{t('table.basket', { basket: one.name })}</h4>
      )}
      <p class="hint">{t('table.basket.how')}</p>
      <div class="camera-numbers">
        <label>
          x <NumberField label={t('table.basket.x')} value={one.x_m} measure="length" onCommit={(x_m) => place({ x_m })} />
        </label>
        <label>
          y <NumberField label={t('table.basket.y')} value={one.y_m} measure="length" onCommit={(y_m) => place({ y_m })} />
        </label>
        <label>
          {t('table.basket.turn')}{' '}
          <NumberField
            label={t('table.basket.turn')}
            value={turnOf(one)}
            measure="angle"
            onCommit={(turn) => place({ quaternion_wxyz: turned(turn) })}
          />
        </label>
      </div>
      {note && (
        <div class={`callout${note.what === 'stays' ? ' camera-fault' : ''}`} role={note.what === 'far' ? 'status' : 'alert'}>
          <p>
            <Icon name="fault" size={15} /> {tWord('table.basket', note.what)}
          </p>
          {note.lines.map((line) => (
            <p key={line}>{line}</p>
          ))}
        </div>
      )}
    </section>
  );
}
