import { defineConfig } from 'vitest/config';

// Everything in one origin and without inline scripts, so that the page lives under
// `script-src 'self'`. The files go where scripts/panel.sh and CMake look for them.
export default defineConfig({
  base: '/',
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  build: {
    outDir: '../build/panel',
    emptyOutDir: true,
    assetsDir: 'assets',
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    target: 'es2022',
    chunkSizeWarningLimit: 1000,
  },
  // The project's own licence stands above this folder.
  server: { fs: { allow: ['..'] } },
  test: { environment: 'node', include: ['src/**/*.test.ts'] },
});
