/** What things in the 3D view are made of, light and dark. */
import {
  Color,
  LineBasicMaterial,
  MeshBasicMaterial,
  MeshLambertMaterial,
  MeshStandardMaterial,
  type MeshStandardMaterialParameters,
} from 'three';

export type Theme = 'light' | 'dark';

/** Neither the accent, which is everywhere, nor the red of Stop and faults. */
export const kAmber = 0xf0a020;
const kNearSteps = 6;

interface Palette {
  background: number;
  floor: number;
  gridMajor: number;
  gridMinor: number;
  shell: number;
  hub: number;
  metal: number;
  plinth: number;
  object: number;
  accent: number;
  fault: number;
  sky: number;
  ground: number;
  light: number;
}

export const kPalettes: Record<Theme, Palette> = {
  light: {
    background: 0xe9ecee,
    floor: 0xdfe3e6,
    gridMajor: 0xb9c0c6,
    gridMinor: 0xcfd5d9,
    shell: 0xf5f6f4,
    hub: 0x59636b,
    metal: 0x9aa4ab,
    plinth: 0xcdd3d7,
    object: 0xb7a98c,
    accent: 0x0e857b,
    fault: 0xc62828,
    sky: 0xffffff,
    ground: 0xb9c1c6,
    light: 2.1,
  },
  dark: {
    background: 0x15191d,
    floor: 0x191e22,
    gridMajor: 0x333c43,
    gridMinor: 0x232a30,
    shell: 0xe3e7e8,
    hub: 0x4a555d,
    metal: 0x9aa5ac,
    plinth: 0x2c343a,
    object: 0x8a7d62,
    accent: 0x35c2b2,
    fault: 0xef5350,
    sky: 0xd6e0e6,
    ground: 0x2a3238,
    light: 2.6,
  },
};

/** One set for all robots; only colours change with the theme. */
export class Materials {
  readonly shell = this.lit({ roughness: 0.55, metalness: 0.05 });
  readonly hub = this.lit({ roughness: 0.5, metalness: 0.25 });
  readonly metal = this.lit({ roughness: 0.35, metalness: 0.6 });
  readonly plinth = this.lit({ roughness: 0.9, metalness: 0 });
  readonly object = this.lit({ roughness: 0.85, metalness: 0 });
  readonly accent = this.lit({ roughness: 0.5, metalness: 0.1 });
  /** Of legs, by how near their limits are: from what is free to what is at its end. */
  readonly near = Array.from({ length: kNearSteps }, () => this.lit({ roughness: 0.4, metalness: 0.2 }));
  readonly ghost = this.lit({
    roughness: 0.7,
    transparent: true,
    opacity: 0.38,
  });
  readonly ghostRefused = this.lit({
    roughness: 0.7,
    transparent: true,
    opacity: 0.38,
  });
  readonly body = new MeshBasicMaterial({ wireframe: true, transparent: true, opacity: 0.22 });
  readonly reach = new MeshBasicMaterial({
    transparent: true,
    opacity: 0.09,
    depthWrite: false,
  });
  readonly reachLines = new LineBasicMaterial({ transparent: true, opacity: 0.28 });
  readonly path = new LineBasicMaterial({ transparent: true, opacity: 0.95 });
  readonly limit = new MeshBasicMaterial({ transparent: true, opacity: 0.22, depthTest: false, side: 2 });
  readonly needle = new LineBasicMaterial({ depthTest: false });

  /** @param plain  of a computer that draws without help: what costs it least */
  constructor(private readonly plain: boolean) {}

  private lit(how: MeshStandardMaterialParameters): MeshStandardMaterial | MeshLambertMaterial {
    const { roughness, metalness, ...both } = how;
    return this.plain ? new MeshLambertMaterial(both) : new MeshStandardMaterial({ roughness, metalness: metalness ?? 0, ...both });
  }

  paint(theme: Theme): void {
    const palette = kPalettes[theme];
    this.shell.color = new Color(palette.shell);
    this.hub.color = new Color(palette.hub);
    this.metal.color = new Color(palette.metal);
    this.plinth.color = new Color(palette.plinth);
    this.object.color = new Color(palette.object);
    this.near.forEach((one, i) => {
      one.color = new Color(palette.metal).lerp(new Color(kAmber), i / (kNearSteps - 1));
    });
    for (const one of [this.accent, this.ghost, this.body, this.reach, this.reachLines, this.path, this.limit, this.needle]) {
      one.color = new Color(palette.accent);
    }
    this.ghost.emissive = new Color(palette.accent).multiplyScalar(0.25);
    this.ghostRefused.color = new Color(palette.fault);
  }
}
