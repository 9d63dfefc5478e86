import { describe, expect, it } from 'vitest';
import { ageText, closedInputs, degrees, servoRows, statusBytes, touchText, warned, type LegJson } from './device';

describe('warnings', () => {
  it('are one row a thing with all its joints, the grave ones first', () => {
    const rows = warned([
      { name: 'not_homed', joint: 'J1' },
      { name: 'step_loss', joint: 'leg1', age_s: 12 },
      { name: 'step_loss', joint: 'leg4', age_s: 3 },
      { name: 'battery_low' },
    ]);
    expect(rows).toEqual([
      { name: 'step_loss', joints: ['leg1', 'leg4'], age: 3, grave: true },
      { name: 'battery_low', joints: [], grave: true },
      { name: 'not_homed', joints: ['J1'], grave: false },
    ]);
  });
});

describe('a status of the hexapod', () => {
  const leg: LegJson = {
    joint: 'leg1',
    bytes: 'E1 DD FF 6F 50 0A 00 01 FF FE 00 00',
    address: 0x61,
    flags: ['step_loss', 'under_voltage', 'over_current_1'],
    temperature: 'normal',
    motion: 'at_target',
    actual_units: 1,
    target_units: -2,
  };
  it('has the values of each byte beside it', () => {
    const bytes = statusBytes(leg);
    expect(bytes).toHaveLength(12);
    expect(bytes[0]).toEqual({ byte: 'E1', values: [['address', '0x61']] });
    expect(bytes[4]).toEqual({ byte: '50', values: [['flags', 'step_loss under_voltage'], ['temperature', 'normal']] });
    expect(bytes[5]!.values).toContainEqual(['flags', 'over_current_1']);
    expect(bytes[8]!.values).toEqual([['target_high', -2]]);
  });
  it('has none before the module was asked', () => {
    expect(statusBytes({ joint: 'leg1' })).toEqual([]);
  });
});

describe('servos', () => {
  it('stand told and read beside each other', () => {
    const rows = servoRows(
      [{ servo: 6, joint: 'base', units: 1500 }, { servo: 1, units: 700 }],
      [{ servo: 6, joint: 'base', units: 1497, position_rad: 0.01 }],
    );
    expect(rows).toEqual([
      { name: '', servo: 1, told: 700 },
      { name: 'base', servo: 6, told: 1500, read: 1497, position: 0.01 },
    ]);
  });
});

describe('numbers', () => {
  it('are in degrees and ages', () => {
    expect(degrees(-Math.PI / 2)).toBe('−90.00°');
    expect(degrees(-1e-7)).toBe('0.00°');
    expect(degrees(undefined)).toBe('–');
    expect(ageText(0.02)).toBe('0.10 s');
    expect(ageText(75)).toBe('1 min 15 s');
  });
});

describe('inputs of a board', () => {
  const inputs = { state: 'Idle', probe: true, door: false, hold: true, reset: false, start: false, emergency_stop: true, end_stops: [] };
  it('names those that are closed besides the probe', () => {
    expect(closedInputs(inputs)).toEqual(['hold', 'emergency_stop']);
  });
  it('says where a joint was, in its own unit', () => {
    expect(touchText({ position_rad: Math.PI / 2 })).toBe('90.000°');
    expect(touchText({ position_m: 0.0125 })).toBe('12.500 mm');
    expect(touchText({})).toBe('–');
  });
});
