// The page is files that any web server can serve under a strict
// Content-Security-Policy: no inline script or style, nothing inlined as data.
import { defineConfig } from 'vite';

export default defineConfig({
  base: './',
  build: {
    target: 'es2021',
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    sourcemap: false,
    chunkSizeWarningLimit: 800,
    rollupOptions: {
      output: {
        // three.js changes seldom: browsers keep it.
        manualChunks: { three: ['three'] },
      },
    },
  },
  server: {
    // `npx vite` beside a running agent, for work on the page.
    proxy: { '/api': process.env.TREELINE_AGENT ?? 'http://127.0.0.1:8090' },
  },
});
