/**
 * What is built in, under which licence and whose it is; versions and texts of the page's parts come from their
 * packages.
 */
import apache from '../../../LICENSE?raw';
import inter from '../../node_modules/@fontsource-variable/inter/LICENSE?raw';
import signals from '../../node_modules/@preact/signals/LICENSE?raw';
import preact from '../../node_modules/preact/LICENSE?raw';
import three from '../../node_modules/three/LICENSE?raw';
import uplot from '../../node_modules/uplot/LICENSE?raw';
import bsd from '../licences/bsd_3_clause.txt?raw';

export interface Part {
  name: string;
  version?: string;
  licence: string;
  /** What has to go along with it; nothing where its licence asks for nothing. */
  text?: string;
}

export const kSinewLicence = 'Apache-2.0';

const kPage: Record<string, { name: string; licence: string; text: string }> = {
  preact: { name: 'Preact', licence: 'MIT', text: preact },
  '@preact/signals': { name: 'Preact Signals', licence: 'MIT', text: signals },
  three: { name: 'three.js', licence: 'MIT', text: three },
  uplot: { name: 'µPlot', licence: 'MIT', text: uplot },
  '@fontsource-variable/inter': { name: 'Inter', licence: 'OFL-1.1', text: inter },
};

/** The licence's own words, behind the line that says whose it is. */
const kMit = preact.slice(preact.indexOf('Permission is hereby granted'));
const mit = (whose: string): string => `Copyright (c) ${whose}\n\n${kMit}`;

export const kProgramParts: readonly Part[] = [
  // Asks for no notice beside a program in machine code.
  { name: 'Boost (Asio, Beast)', licence: 'BSL-1.0' },
  { name: 'OpenSSL', licence: 'Apache-2.0', text: `Copyright 1995-2023 The OpenSSL Project Authors\n\n${apache}` },
  { name: 'nlohmann/json', licence: 'MIT', text: mit('2013-2022 Niels Lohmann') },
  { name: 'toml++', licence: 'MIT', text: mit('2020-2022 Mark Gillard') },
  {
    name: 'CLI11',
    licence: 'BSD-3-Clause',
    text: `Copyright (c) 2017-2022 University of Cincinnati, developed by Henry Schreiner\n\n${bsd}`,
  },
  { name: '{fmt}', licence: 'MIT', text: mit('2012-2022 Victor Zverovich') },
];

/** @return  all that the page is built from; one that nobody has looked at says so */
export function pageParts(dependencies: Readonly<Record<string, string>>): Part[] {
  return Object.entries(dependencies).map(([id, version]) => ({
    name: kPage[id]?.name ?? id,
    version,
    licence: kPage[id]?.licence ?? '?',
    text: kPage[id]?.text,
  }));
}
