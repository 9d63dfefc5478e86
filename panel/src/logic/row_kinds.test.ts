import { describe, expect, it } from 'vitest';
import { fieldsOf, hereRow, kWords, newRows, readField, writeField, wordsOf } from './row_kinds';
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

describe('a row taught where the arm is', () => {
  const at = (raw: string, robot: string, joints: number[]) => hereRow(raw, named(robot), joints, toolPose(named(robot), joints));

  it('goes there, whatever place it said before, and keeps what else it says', () => {
    const joints = named('learm').joints.map(() => 0.1);
    const row = at('  line dx=10mm frame=tool dz=-5mm to=bin pitch=90deg speed=80mm/s blend=5mm  # slowly', 'learm', joints);
    expect(row).toMatch(/^ {2}line x=[-\d.]+mm y=[-\d.]+mm z=[-\d.]+mm speed=80mm\/s blend=5mm {2}# slowly$/);
    expect(at('arc via=1mm,2mm,3mm x=1mm speed=80mm/s', 'learm', joints)).toMatch(/^arc x=\S+ y=\S+ z=\S+ via=1mm,2mm,3mm speed=80mm\/s$/);
  });

  it('says how the tool is turned where its rows can', () => {
    const arm = named('robot-arm-2');
    const joints = arm.joints.map((_, i) => 0.1 * i);
    const words = at('move rz=1deg drx=5deg x=1mm', 'robot-arm-2', joints).split(' ');
    expect(words.map((one) => one.split('=')[0])).toEqual(['move', 'x', 'y', 'z', 'rx', 'ry', 'rz']);
    expect(words.slice(4)).not.toEqual(['rx=0deg', 'ry=0deg', 'rz=0deg']);
    expect(newRows('line', arm, joints, toolPose(arm, joints))[0]).toBe(at('line', 'robot-arm-2', joints));
  });

  it('has all joints by their names, whatever they were called', () => {
    const arm = named('robot-arm-2');
    const joints = arm.joints.map(() => 0.1);
    const row = at(`joint d.${arm.joints[0]!.name}=5deg J2=3deg speed=50%`, 'robot-arm-2', joints);
    expect(row).toBe(`joint ${arm.joints.map((one) => `${one.name}=5.73deg`).join(' ')} speed=50%`);
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

  it('know a joint by its number too, and by how far it goes', () => {
    const tokens = readRows('joint J2=-20deg d.base=5deg').rows[0]!.tokens;
    expect(readField(tokens, field('joint', 'shoulder'))).toBe('-20deg');
    expect(readField(tokens, field('joint', 'd.base'))).toBe('5deg');
    expect(writeField('joint J2=-20deg speed=50%', field('joint', 'shoulder'), '10')).toEqual({ raw: 'joint shoulder=10deg speed=50%' });
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
