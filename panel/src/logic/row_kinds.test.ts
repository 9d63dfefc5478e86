import { describe, expect, it } from 'vitest';
import { fieldsOf, kWords, newRows, readField, writeField, wordsOf } from './row_kinds';
import { toolPose } from './kinematics';
import { readRows } from './rows';
import fixture from './models.fixture.json';
import type { RobotModel } from './types';

const models = Object.values(fixture as unknown as Record<string, RobotModel>);
const named = (id: string): RobotModel => models.find((one) => one.robot === id)!;
const field = (word: string, id: string, robot = 'learm') => fieldsOf(word, named(robot)).find((one) => one.id === id)!;

describe('steps', () => {
  it('are offered where the robot can do them', () => {
    expect(wordsOf(named('learm'))).toContain('jaws');
    expect(wordsOf(named('learm'))).not.toContain('suction');
    expect(wordsOf(named('maxarm'))).toContain('suction');
    expect(wordsOf(named('maxarm'))).not.toContain('gripper');
  });

  it('can each be put into a program as a whole block', () => {
    for (const model of models) {
      const joints = model.joints.map(() => 0.1);
      for (const word of kWords) {
        const rows = newRows(word, model, joints, toolPose(model, joints));
        expect(readRows(rows.join('\n')).whole, word).toBe(true);
        expect(rows[0]!.startsWith(word)).toBe(true);
      }
    }
  });

  it('ask for the turns that the tool has', () => {
    const ids = (robot: string) => fieldsOf('line', named(robot)).map((one) => one.id);
    expect(ids('learm')).toContain('pitch');
    expect(ids('hexapod')).toContain('rx');
    expect(ids('maxarm')).not.toContain('rx');
  });
});

describe('fields', () => {
  const raw = '  joint base=30deg speed=50%  # slowly';

  it('are read from the row', () => {
    const tokens = readRows(raw).rows[0]!.tokens;
    expect(readField(tokens, field('joint', 'base'))).toBe('30deg');
    expect(readField(tokens, field('joint', 'elbow'))).toBe('');
    expect(readField('wait until z<100mm for 5s'.split(' '), field('wait', 'wait'))).toBe('until z<100mm for 5s');
  });

  it('take the usual unit where none is said, and a comma', () => {
    expect(writeField(raw, field('joint', 'base'), '12,5')).toEqual({ raw: '  joint base=12.5deg speed=50%  # slowly' });
    expect(writeField(raw, field('joint', 'elbow'), '0.5rad')).toEqual({
      raw: '  joint base=30deg speed=50% elbow=0.5rad  # slowly',
    });
    expect(writeField('line x=1mm', field('line', 'speed'), '80')).toEqual({ raw: 'line x=1mm speed=80mm/s' });
  });

  it('say what is wrong, and leave the row then', () => {
    expect(writeField(raw, field('joint', 'base'), '120')).toMatchObject({ wrong: 'high' });
    expect(writeField(raw, field('joint', 'base'), '20mm')).toEqual({ wrong: 'number' });
    expect(writeField('jaws 10mm', field('jaws', 'width'), '')).toEqual({ wrong: 'needed' });
    expect(writeField('loop 2', field('loop', 'count'), '0')).toMatchObject({ wrong: 'low' });
    expect(writeField('loop 2', field('loop', 'count'), '2.5')).toEqual({ wrong: 'number' });
  });

  it('of several words keep what stands beside them', () => {
    expect(writeField('spline 1mm,2mm,3mm speed=50%  # r', field('spline', 'points'), 'a b')).toEqual({
      raw: 'spline a b speed=50%  # r',
    });
    expect(writeField('wait 1s', field('wait', 'wait'), 'until x>=2mm for 5s')).toEqual({ raw: 'wait until x>=2mm for 5s' });
  });
});
