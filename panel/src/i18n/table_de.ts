/** Körbe, Würfel, die nicht zu greifen sind, und der Greifbereich; mit den Schlüsseln von table_en.ts. */
import type { tableEn } from './table_en';

export const tableDe: Record<keyof typeof tableEn, string> = {
  'prog.field.into': 'Korb oder Punkt',
  'prog.field.camera': 'Kamera',

  'table.cannot': 'So nicht zu greifen',
  'table.to_fix': 'Abhilfe: {help}',
  'table.reach': 'Greifbereich',
  'table.reach.straight': 'senkrecht gegriffen',
  'table.reach.tilted': 'geneigt gegriffen',
  'table.reach.of': 'Für einzelne Würfel von {edge} mm auf dem Tisch, eine Seite zum Roboter gedreht',
  'table.reach.under_way': 'zu {percent} % berechnet',
  'table.baskets': 'Korb',
  'table.basket': 'Korb: {basket}',
  'table.basket.drag': '{basket}: dorthin ziehen, wo er steht',
  'table.basket.how': 'Den Korb im Bild dorthin ziehen, wo er steht, oder die Mitte seines Bodens eintippen.',
  'table.basket.x': 'Korb, x in der Zelle',
  'table.basket.y': 'Korb, y in der Zelle',
  'table.basket.turn': 'Drehung',
  'table.basket.far': 'Verschoben, aber nicht in Reichweite jedes Roboters',
  'table.basket.unanswered': 'Es kam keine Antwort. Das Bild zeigt, wo der Korb gilt',
  'table.basket.unsaved': 'Versetzt, aber nicht gespeichert',
  'table.basket.stays': 'Der Korb wurde nicht verschoben',

  'cube.help.out_of_reach': 'den Würfel näher zur Mitte des Greifbereichs legen',
  'cube.help.joint_limit': 'den Würfel näher zur Mitte des Greifbereichs legen',
  'cube.help.too_close': 'den Würfel weiter vom Roboter weg legen',
  'cube.help.cube_crowded': 'den Würfel von seinen Nachbarn wegrücken, oder diese zuerst greifen',
  'cube.help.cube_covered': 'zuerst den Würfel greifen, der auf ihm steht',
  'cube.help.cube_too_wide': 'den Würfel von Hand nehmen, oder cube_mm der Kamera auf seine wirkliche Größe setzen',
  'cube.help.collision': 'den Würfel von dem wegrücken, was neben ihm steht',
  'cube.help.cell_contact': 'den Würfel von dem wegrücken, was neben ihm steht',
  'cube.help.jaws_contact': 'den Würfel von dem wegrücken, was neben ihm steht',
  'cube.help.cell_taken': 'warten, bis der andere Roboter weggefahren ist',
};
