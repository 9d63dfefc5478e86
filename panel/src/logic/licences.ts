/** What is built in, and under which licence; versions of the page's parts come from its package.json. */
export interface Part {
  name: string;
  version?: string;
  licence: string;
}

export const kSinewLicence = 'Apache-2.0';

const kPage: Record<string, { name: string; licence: string }> = {
  preact: { name: 'Preact', licence: 'MIT' },
  '@preact/signals': { name: 'Preact Signals', licence: 'MIT' },
  three: { name: 'three.js', licence: 'MIT' },
  uplot: { name: 'µPlot', licence: 'MIT' },
  '@fontsource-variable/inter': { name: 'Inter', licence: 'OFL-1.1' },
};

export const kProgramParts: readonly Part[] = [
  { name: 'Boost (Asio, Beast)', licence: 'BSL-1.0' },
  { name: 'OpenSSL', licence: 'Apache-2.0' },
  { name: 'nlohmann/json', licence: 'MIT' },
  { name: 'toml++', licence: 'MIT' },
  { name: 'CLI11', licence: 'BSD-3-Clause' },
  { name: '{fmt}', licence: 'MIT' },
];

/** @return  all that the page is built from; one that nobody has looked at says so */
export function pageParts(dependencies: Readonly<Record<string, string>>): Part[] {
  return Object.entries(dependencies).map(([id, version]) => ({
    name: kPage[id]?.name ?? id,
    version,
    licence: kPage[id]?.licence ?? '?',
  }));
}
