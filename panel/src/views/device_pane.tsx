import type { ComponentChildren, JSX } from 'preact';
import { useEffect, useState } from 'preact/hooks';
import { errorSentence, t, tWord } from '../i18n';
import { model, robot, status, store } from '../app';
import { device } from '../device_state';
import { ageText, closedInputs, degrees, servoRows, statusBytes, touchText, warned, type AxisJson, type BusServoJson, type DeviceJson, type GroupJson, type Heard, type InputsJson, type LegJson, type ServoJson, type Warned } from '../logic/device';
import { decimals } from '../logic/units';
import { Icon } from './parts';

/** What the device says of itself: decoded, with its bytes and their age. */
export function DevicePane(): JSX.Element {
  const told = device.value;
  if (!robot.value || !model.value) return <p class="empty">{t('robot.pick')}</p>;
  if (!told) return <p class="empty">{t('device.asking')}</p>;
  return (
    <div class="pane-body device" data-tour="device">
      <Warnings rows={warned(told.warnings)} />
      {told.legs && <Legs legs={told.legs} />}
      {told.wire === 'lsc' && <ServoBoard told={told} />}
      {told.wire === 'maxarm' && <MaxArm told={told} />}
      {told.wire === 'bigrobotarm' && <BigRobotArm told={told} />}
      {told.arm && <ArmLink told={told} arm={told.arm} />}
      {told.bus_servos && <BusServos servos={told.bus_servos} />}
      {told.axes && <Axes told={told} axes={told.axes} />}
      {told.inputs && <Inputs told={told} inputs={told.inputs} />}
      <Line told={told} />
      <p class="hint">{tWord('device.about', told.wire)}</p>
    </div>
  );
}

function Warnings({ rows }: { rows: Warned[] }): JSX.Element {
  const grave = rows.some((one) => one.grave);
  return (
    <section class="device-warnings" aria-label={t('device.warnings')} aria-live="polite">
      {rows.length === 0 ? (
        <p class="device-fine">
          <Icon name="check" size={16} /> {t('device.fine')}
        </p>
      ) : (
        rows.map((one) => (
          <div class={`callout device-warning${one.grave ? ' grave' : ''}`} key={one.name}>
            <h4>
              <Icon name={one.grave ? 'fault' : 'help'} size={17} /> {tWord('device.warn', one.name)}
              {one.joints.length > 0 && <span class="device-where">{one.joints.join(', ')}</span>}
            </h4>
            <p>
              {tWord('device.do', one.name)}
              {one.age !== undefined && <span class="muted"> {t('device.told_ago', { age: ageText(one.age) })}</span>}
            </p>
          </div>
        ))
      )}
      {grave && <span class="sr-only">{t('device.grave')}</span>}
    </section>
  );
}

/** A part of the device: its name, how old what follows is, what follows. */
function Part(props: { name: string; heard?: Heard; grave?: boolean; state?: string; children?: ComponentChildren }): JSX.Element {
  const { heard } = props;
  return (
    <article class={`device-part${props.grave ? ' grave' : ''}`}>
      <header>
        <h4>{props.name}</h4>
        {props.state && <span class="device-state">{props.state}</span>}
        <Age heard={heard} />
      </header>
      {props.children}
    </article>
  );
}

function Age({ heard }: { heard?: Heard }): JSX.Element | null {
  if (heard?.age_s === undefined) return <span class="device-age">{t('device.never')}</span>;
  return (
    <span class="device-age" title={t('device.age')}>
      {t('device.ago', { age: ageText(heard.age_s) })}
    </span>
  );
}

/** Bytes as they stand on the wire. */
function Raw({ bytes }: { bytes?: string }): JSX.Element | null {
  return bytes ? (
    <code class="raw" aria-label={t('device.bytes')}>
      {bytes}
    </code>
  ) : null;
}

function Values({ rows }: { rows: (readonly [string, ComponentChildren] | null | false)[] }): JSX.Element {
  return (
    <dl class="device-values">
      {rows.map(
        (row) =>
          row && (
            <div key={row[0]}>
              <dt>{row[0]}</dt>
              <dd>{row[1]}</dd>
            </div>
          ),
      )}
    </dl>
  );
}

// --- Hexapod.

function Legs({ legs }: { legs: LegJson[] }): JSX.Element {
  return (
    <section class="device-parts" aria-label={t('device.legs')}>
      <h3>{t('device.legs')}</h3>
      {legs.map((leg) => (
        <Part
          key={leg.joint}
          name={leg.joint}
          heard={leg}
          grave={(leg.flags?.length ?? 0) > 0}
          state={leg.motion && tWord('device.motion', leg.motion)}
        >
          {leg.bytes && (
            <>
              <Values
                rows={[
                  [t('device.flags'), leg.flags?.length ? leg.flags.map((one) => tWord('device.warn', one)).join(', ') : t('device.none')],
                  [t('device.temperature'), tWord('device.temperature', leg.temperature ?? '')],
                  [t('device.counters'), t('device.counters.text', { actual: leg.actual_units ?? 0, target: leg.target_units ?? 0 })],
                  [t('device.currents'), t('device.currents.text', { run: leg.run_current_ma ?? 0, hold: leg.hold_current_ma ?? 0 })],
                ]}
              />
              <LegBytes leg={leg} />
              {leg.last_trouble && leg.last_trouble.bytes !== leg.bytes && (
                <p class="device-trouble">
                  {t('device.last_trouble', {
                    flags: leg.last_trouble.flags.map((one) => tWord('device.warn', one)).join(', '),
                    age: ageText(leg.last_trouble.age_s ?? 0),
                  })}
                  <Raw bytes={leg.last_trouble.bytes} />
                </p>
              )}
            </>
          )}
        </Part>
      ))}
    </section>
  );
}

function LegBytes({ leg }: { leg: LegJson }): JSX.Element {
  const value = (name: string, of: string | number | boolean): string => {
    if (of === '') return name === 'flags' ? t('device.none') : '';
    if (name === 'flags') return String(of).split(' ').map((one) => tWord('device.warn', one)).join(', ');
    if (typeof of === 'boolean') return t(of ? 'device.yes' : 'device.no');
    return name === 'motion' || name === 'temperature' ? tWord(`device.${name}`, String(of)) : String(of);
  };
  return (
    <details class="leg-bytes">
      <summary>
        <Raw bytes={leg.bytes} />
      </summary>
      <ol start={0}>
        {statusBytes(leg).map((one, i) => (
          <li key={i}>
            <code>{one.byte}</code>
            <span>
              {one.values.map(([name, of]) => `${tWord('device.byte', name)}${value(name, of) && `: ${value(name, of)}`}`).join('; ')}
            </span>
          </li>
        ))}
      </ol>
    </details>
  );
}

// --- Servos.

function ServoTable(props: { told?: ServoJson[]; read?: ServoJson[]; unit: string; heads: [string, string] }): JSX.Element {
  const rows = servoRows(props.told, props.read);
  const numbered = rows.some((one) => one.servo !== undefined);
  return (
    <table class="device-table">
      <thead>
        <tr>
          {numbered && <th scope="col">{t('device.servo')}</th>}
          <th scope="col">{t('device.joint')}</th>
          <th scope="col" class="num">{props.heads[0]}</th>
          <th scope="col" class="num">{props.heads[1]}</th>
          <th scope="col" class="num">{t('device.angle')}</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((one) => (
          <tr key={one.servo ?? one.name} class={one.read === -1 ? 'grave' : ''}>
            {numbered && <td>{one.servo}</td>}
            <th scope="row">{one.name || t('device.jaws')}</th>
            <td class="num">{one.told ?? '–'}</td>
            <td class="num">{one.read ?? '–'}</td>
            <td class="num">{degrees(one.position, 1)}</td>
          </tr>
        ))}
      </tbody>
      <caption>{props.unit}</caption>
    </table>
  );
}

function ServoBoard({ told }: { told: DeviceJson }): JSX.Element {
  const battery = told.battery;
  const unit = t(told.unit === 'bus' ? 'device.unit.bus' : 'device.unit.us');
  return (
    <>
      <Part
        name={t('device.battery')}
        heard={battery}
        grave={battery && battery.volts < battery.notice_below_volts}
        state={battery && `${decimals(battery.volts, 2)} V`}
      >
        {battery ? (
          <>
            <p class="hint">
              {t('device.battery.text', { notice: decimals(battery.notice_below_volts, 1), fault: decimals(battery.fault_below_volts, 1) })}
            </p>
            <Raw bytes={battery.bytes} />
          </>
        ) : (
          <p class="hint">{t(told.board === 'esp32' ? 'device.battery.untold' : 'device.unasked')}</p>
        )}
      </Part>
      <Part name={t('device.board')} heard={told.version ?? told.positions ?? battery} state={tWord('device.board', told.board ?? '')}>
        <p class="hint">{tWord('device.board.text', told.board ?? '')}</p>
        {told.version && (
          <Values rows={[[t('device.version'), `${told.version.version} (${t('device.version.type', { type: told.version.type })})`]]} />
        )}
      </Part>
      <Part name={t('device.servos')} heard={told.positions ?? told.told}>
        <ServoTable
          told={told.told?.servos}
          read={told.positions?.servos}
          unit={unit}
          heads={[t('device.told'), t(told.positions && !told.positions.measured ? 'device.now' : 'device.measured')]}
        />
        <Raw bytes={told.told?.bytes} />
      </Part>
      <Part name={t('device.groups')} heard={told.group_started ?? told.group_finished ?? told.group_stopped}>
        <Values
          rows={[
            groupRow('device.group.started', told.group_started),
            groupRow('device.group.finished', told.group_finished),
            groupRow('device.group.stopped', told.group_stopped),
          ]}
        />
        <p class="hint">{t('device.groups.text')}</p>
      </Part>
    </>
  );
}

function groupRow(name: 'device.group.started' | 'device.group.finished' | 'device.group.stopped', group?: GroupJson): [string, ComponentChildren] | null {
  if (!group) return null;
  const what = group.group === undefined ? '' : t('device.group.which', { group: group.group, times: group.times ?? 0 });
  return [t(name), `${what} ${t('device.ago', { age: ageText(group.age_s ?? 0) })}`.trim()];
}

// --- MaxArm.

function MaxArm({ told }: { told: DeviceJson }): JSX.Element {
  return (
    <>
      <Part name={t('device.answers')} heard={told.angles} state={tWord('device.board', told.board ?? '')}>
        <Values rows={[[t('device.checksum'), told.checksum ? tWord('device.checksum', told.checksum) : t('device.checksum.open')]]} />
      </Part>
      <Part name={t('device.read_back')} heard={told.angles}>
        <ServoTable
          told={told.told?.servos}
          read={told.angles?.servos}
          unit={t('device.unit.pulse')}
          heads={[t('device.told'), t('device.measured')]}
        />
        <Raw bytes={told.angles?.bytes} />
      </Part>
      <Part name={t('device.nozzle')} heard={told.position} state={told.position && `${told.position.xyz_mm.join(', ')} mm`}>
        <p class="hint">{t('device.nozzle.text')}</p>
        <Raw bytes={told.position?.bytes} />
      </Part>
    </>
  );
}

// --- Servos on a bus of their own.

function BusServos({ servos }: { servos: BusServoJson[] }): JSX.Element {
  const numbers = (value: number | undefined, digits = 0): string => (value === undefined ? '–' : decimals(value, digits));
  const oldest = servos.reduce((age, one) => Math.max(age, one.age_s ?? 0), 0);
  return (
    <Part name={t('device.bus_servos')} heard={servos.some((one) => one.age_s !== undefined) ? { age_s: oldest } : {}}>
      <table class="device-table">
        <thead>
          <tr>
            <th scope="col">{t('device.joint')}</th>
            <th scope="col" class="num">{t('device.servo')}</th>
            <th scope="col" class="num">{t('device.measured')}</th>
            <th scope="col" class="num">{t('device.load')}</th>
            <th scope="col" class="num">°C</th>
            <th scope="col" class="num">V</th>
            <th scope="col" class="num">{t('device.motor')}</th>
          </tr>
        </thead>
        <tbody>
          {servos.map((one) => (
            <tr key={one.joint} class={one.answers ? '' : 'grave'}>
              <th scope="row" title={one.model === undefined ? undefined : t('device.servo.title', { model: one.model, firmware: one.firmware ?? '' })}>
                {one.joint}
              </th>
              <td class="num">{one.servo}</td>
              <td
                class="num"
                title={t('device.units.title', { units: one.units ?? 0, lowest: one.lowest_units ?? 0, highest: one.highest_units ?? 0 })}
              >
                {one.width_m === undefined ? degrees(one.position_rad, 1) : `${decimals(1000 * one.width_m, 1)} mm`}
              </td>
              <td class="num">{one.load === undefined ? '–' : `${decimals(100 * Math.abs(one.load), 0)} %`}</td>
              <td class="num">{numbers(one.temperature_c)}</td>
              <td class="num">{numbers(one.volts, 1)}</td>
              <td class="num">{t(!one.answers ? 'device.motor.silent' : one.motor_on ? 'device.motor.on' : 'device.motor.off')}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </Part>
  );
}

// --- A board with inputs of its own.

function Inputs({ told, inputs }: { told: DeviceJson; inputs: InputsJson }): JSX.Element {
  const others = closedInputs(inputs);
  return (
    <Part name={t('device.inputs')} heard={inputs} state={tWord('device.firmware', told.firmware ?? '')}>
      <Values
        rows={[
          [t('device.inputs.state'), inputs.state],
          [t('device.inputs.probe'), t(inputs.probe ? 'device.inputs.closed' : 'device.inputs.open')],
          told.touched
            ? [
                t('device.inputs.touched'),
                t('device.inputs.touched.at', { joint: told.touched.joint, place: touchText(told.touched), age: ageText(told.touched.age_s ?? 0) }),
              ]
            : null,
          [t('device.inputs.end_stops'), inputs.end_stops.join(', ') || t('device.none')],
          [t('device.inputs.others'), others.map((one) => tWord('device.input', one)).join(', ') || t('device.none')],
        ]}
      />
    </Part>
  );
}

// --- BigRobotArm.

function BigRobotArm({ told }: { told: DeviceJson }): JSX.Element {
  const one = told.status;
  return (
    <Part name={t('device.counters.steps')} heard={one} state={tWord('device.spoken', told.spoken ?? '')}>
      {one && (
        <>
          <table class="device-table">
            <thead>
              <tr>
                <th scope="col">{t('device.joint')}</th>
                <th scope="col" class="num">{t('device.microsteps')}</th>
                <th scope="col" class="num">{t('device.speed')}</th>
                <th scope="col" class="num">{t('device.acceleration')}</th>
              </tr>
            </thead>
            <tbody>
              {one.joints.map((joint) => (
                <tr key={joint.joint}>
                  <th scope="row">{joint.joint}</th>
                  <td class="num">{joint.steps}</td>
                  <td class="num">{decimals(joint.speed_rev_s, 2)}</td>
                  <td class="num">{decimals(joint.acceleration_rev_s2, 2)}</td>
                </tr>
              ))}
            </tbody>
            <caption>{t('device.unit.revs')}</caption>
          </table>
          <Values
            rows={[
              [t('device.gripper'), one.gripper ? t(one.gripper.enabled ? 'device.gripper.on' : 'device.gripper.off', { deg: one.gripper.servo_deg }) : t('device.gripper.untold')],
              [t('device.sync'), t(one.sync ? 'device.yes' : 'device.no')],
            ]}
          />
          <Raw bytes={one.bytes} />
        </>
      )}
    </Part>
  );
}

// --- Its board with our firmware.

function ArmLink({ told, arm }: { told: DeviceJson; arm: NonNullable<DeviceJson['arm']> }): JSX.Element {
  const { image, statistics } = told;
  const servo = Math.round(arm.gripper.servo_deg);
  return (
    <>
      <Part name={t('device.counters.steps')} heard={arm} grave={arm.fault !== 'none'} state={arm.moving ? t('device.arm.moves', { ms: arm.queued_ms }) : t('device.arm.rests')}>
        <table class="device-table">
          <thead>
            <tr>
              <th scope="col">{t('device.joint')}</th>
              <th scope="col" class="num">{t('device.microsteps')}</th>
            </tr>
          </thead>
          <tbody>
            {arm.joints.map((joint) => (
              <tr key={joint.joint}>
                <th scope="row">{joint.joint}</th>
                <td class="num">{decimals(joint.steps, 2)}</td>
              </tr>
            ))}
          </tbody>
        </table>
        <Values
          rows={[
            [t('device.arm.reference'), tWord('device.arm.reference', arm.reference)],
            [t('device.arm.fault'), tWord('device.arm.fault', arm.fault)],
            [t('device.gripper'), t(arm.gripper.enabled ? 'device.gripper.on' : 'device.gripper.off', { deg: servo })],
          ]}
        />
      </Part>
      {(image || statistics) && (
        <Part
          name={t('device.image')}
          heard={statistics ?? image}
          state={image && t('device.image.text', { board: image.board, version: image.version, build: image.checksum.toString(16).padStart(8, '0') })}
        >
          {statistics && (
            <Values
              rows={[
                [t('device.statistics'), statistics.starts],
                [t('device.statistics.line'), t('device.statistics.line.text', { lost: statistics.bytes_lost, bad: statistics.frames_bad })],
                [
                  t('device.statistics.time'),
                  t('device.statistics.time.text', { late: statistics.late_slices, us: statistics.loop_us_max, stack: statistics.stack_free_bytes }),
                ],
              ]}
            />
          )}
        </Part>
      )}
    </>
  );
}

// --- Axis boards.

function Axes({ told, axes }: { told: DeviceJson; axes: AxisJson[] }): JSX.Element {
  return (
    <section class="device-parts" aria-label={t('device.axes')}>
      <h3>{t('device.axes')}</h3>
      {told.reports_status !== false && <SelfTest key={robot.value} name={robot.value!} axes={axes} />}
      {axes.map((axis) => (
        <Axis key={axis.joint} axis={axis} blank={told.reports_status === false} />
      ))}
    </section>
  );
}

/** What it found wrong stands at the board; the refusal that says so beside the button. */
function SelfTest({ name, axes }: { name: string; axes: AxisJson[] }): JSX.Element {
  const [state, setState] = useState<'idle' | 'busy' | 'passed'>('idle');
  const test = async () => {
    setState('busy');
    setState((await store.selfTest(name)) ? 'passed' : 'idle');
  };
  const ready = status.value?.state === 'ready';
  const well = ready && axes.every((axis) => axis.answers && !axis.fault);
  useEffect(() => {
    if (!well) setState((now) => (now === 'passed' ? 'idle' : now));
  }, [well]);
  return (
    <p class="device-test">
      <button type="button" disabled={state === 'busy' || !ready} title={t('device.test.help')} onClick={() => void test()}>
        {t('device.test')}
      </button>
      <span class="muted" aria-live="polite">
        {state === 'passed' && t('device.test.passed')}
        {state === 'busy' && t('device.test.busy')}
      </span>
    </p>
  );
}

function Axis({ axis, blank }: { axis: AxisJson; blank: boolean }): JSX.Element {
  const newest = [axis, axis.health, ...(axis.registers ?? [])]
    .filter((one) => one?.age_s !== undefined)
    .sort((a, b) => a!.age_s! - b!.age_s!)[0];
  const state = axis.fault ? errorSentence(axis.fault) : t(axis.answers ? 'device.axis.answers' : 'device.axis.silent');
  return (
    <Part name={axis.joint} heard={newest} grave={!!axis.fault || !axis.answers} state={axis.fault ? undefined : state}>
      {axis.fault && <p class="device-trouble">{state}</p>}
      {axis.position_rad !== undefined && (
        <Values
          rows={[
            [t('device.position'), `${degrees(axis.position_rad)} (${axis.position_units})`],
            [t('device.following'), axis.following_error_rad === undefined ? t('device.following.none') : degrees(axis.following_error_rad, 3)],
            axis.identity && [t('device.encoder_error'), `± ${degrees(axis.identity.uncertainty_rad, 3)}`],
            axis.health && [
              t('device.health'),
              [
                axis.health.supply_v !== undefined && `${decimals(axis.health.supply_v, 1)} V`,
                axis.health.temperature_c !== undefined && `${decimals(axis.health.temperature_c, 0)} °C`,
              ].filter(Boolean).join(', ') || t('device.unmeasured'),
            ],
            axis.health && (axis.health.motor_magnet || axis.health.joint_magnet) && [
              t('device.magnets'),
              [
                axis.health.motor_magnet && t('device.magnet.motor', { magnet: t(`device.magnet.${axis.health.motor_magnet}`) }),
                axis.health.joint_magnet && t('device.magnet.joint', { magnet: t(`device.magnet.${axis.health.joint_magnet}`) }),
              ].filter(Boolean).join(', '),
            ],
            axis.zero_shift_rad !== undefined && [t('device.zero_shift'), degrees(axis.zero_shift_rad, 3)],
            [t('device.failed_frames'), axis.failed_frames ?? 0],
            axis.late_frames !== undefined && [t('device.late_frames'), axis.late_frames],
            axis.identity && [t('device.model_hash'), `${axis.identity.model_hash.toString(16).toUpperCase().padStart(8, '0')}, ${t('device.boots', { count: axis.identity.boot })}`],
          ].map((row) => row || null) as [string, ComponentChildren][]}
        />
      )}
      {axis.flags && <Flags flags={axis.flags} />}
      {blank && <p class="hint">{t('device.axis.blank')}</p>}
      {(axis.registers?.length ?? 0) > 0 && <Registers axis={axis} />}
    </Part>
  );
}

/** Good news where it is quiet: what is bad when it is there, or when it is not. */
const kBadWhenOn = new Set(['end_stop', 'emergency_stop']);
const kBadWhenOff = new Set(['motor_ok', 'sensor_ok', 'communication_ok', 'position_ok', 'homed']);

function Flags({ flags }: { flags: Record<string, boolean> }): JSX.Element {
  return (
    <ul class="device-flags" aria-label={t('device.flags')}>
      {Object.entries(flags).map(([name, on]) => {
        const bad = on ? kBadWhenOn.has(name) : kBadWhenOff.has(name);
        return (
          <li key={name} class={bad ? 'bad' : on ? 'on' : 'off'}>
            <Icon name={bad ? 'fault' : on ? 'check' : 'minus'} size={13} />
            {tWord('device.flag', name)}
            <span class="sr-only">: {t(on ? 'device.yes' : 'device.no')}</span>
          </li>
        );
      })}
    </ul>
  );
}

function Registers({ axis }: { axis: AxisJson }): JSX.Element {
  return (
    <table class="device-table registers">
      <thead>
        <tr>
          <th scope="col">{t('device.register')}</th>
          <th scope="col">{t('device.value')}</th>
          <th scope="col">{t('device.raw')}</th>
          <th scope="col" class="num">{t('device.age')}</th>
        </tr>
      </thead>
      <tbody>
        {axis.registers!.map((one) => (
          <tr key={one.register}>
            <th scope="row">
              {one.register.toUpperCase()} <span class="muted">{t(one.written ? 'device.written' : 'device.read')}</span>
            </th>
            <td>
              {one.position_rad !== undefined
                ? degrees(one.position_rad)
                : one.fault_number !== undefined
                  ? t('device.fault_number', { number: one.fault_number })
                  : (one.value ?? '')}
            </td>
            <td>
              <code>{one.bytes}</code>
            </td>
            <td class="num">{ageText(one.age_s ?? 0)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

/** The line itself, as the driver counts. */
function Line({ told }: { told: DeviceJson }): JSX.Element {
  const health = status.value?.health ?? {};
  const here = store.robots.value.find((one) => one.name === told.robot);
  const count = (name: string) => (health[name] ?? 0).toLocaleString();
  return (
    <Part name={t('device.line')} heard={{ age_s: 0 }} state={here?.simulated ? t('app.simulated') : undefined}>
      <Values
        rows={[
          [t('device.port'), <code>{told.port}</code>],
          [t('device.exchanges'), count('requests')],
          [t('device.failures'), t('device.failures.text', { timeouts: count('timeouts'), retries: count('retries'), unexpected: count('unexpected') })],
          [t('device.traffic'), t('device.traffic.text', { down: count('bytes_to_device'), up: count('bytes_to_host') })],
        ]}
      />
    </Part>
  );
}
