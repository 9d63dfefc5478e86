import { describe, expect, it } from 'vitest';
import fixture from '../logic/models.fixture.json';
import { robotsDe } from './robots_de';
import { robotsEn } from './robots_en';

describe('pages about robots', () => {
  it('are there for every kind that has a model here', () => {
    for (const { robot } of Object.values(fixture)) expect(robotsEn[robot], robot).toBeDefined();
  });

  it('have the same rows in every language, and none is empty', () => {
    expect(Object.keys(robotsDe)).toEqual(Object.keys(robotsEn));
    for (const [id, english] of Object.entries(robotsEn)) {
      const german = robotsDe[id]!;
      for (const part of ['wiring', 'before', 'works', 'simulated'] as const) {
        expect(german[part].length, `${id} ${part}`).toBe(english[part].length);
        for (const text of [...german[part], ...english[part]].flat()) expect(text.trim()).not.toBe('');
      }
    }
  });
});
