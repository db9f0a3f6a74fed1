// Colours of heat maps: from dark blue by green and yellow to red; what is beyond a limit is magenta.
'use strict';

const heatStops = [[0, 32, 42, 92], [0.25, 38, 120, 160], [0.5, 84, 178, 120], [0.75, 236, 206, 84], [1, 222, 66, 46]];

// Colour (0 ... 255) of a share of the bar.
function heatColor(share) {
  let i = 1;
  while (i < heatStops.length - 1 && heatStops[i][0] < share) ++i;
  const a = heatStops[i - 1], b = heatStops[i], s = Math.min(1, Math.max(0, (share - a[0]) / (b[0] - a[0])));
  return [1, 2, 3].map(k => a[k] + (b[k] - a[k]) * s);
}

// The bar as linear colours for shaders, 256 x 1.
function heatRamp() {
  const bytes = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; ++i) {
    const color = heatColor(i / 255).map(c => 255 * Math.pow(c / 255, 2.2));
    bytes.set([color[0], color[1], color[2], 255], 4 * i);
  }
  const texture = new THREE.DataTexture(bytes, 256, 1, THREE.RGBAFormat);
  texture.needsUpdate = true;
  return texture;
}

function paintRamp(canvas) {
  const context = canvas.getContext('2d');
  for (let x = 0; x < canvas.width; ++x) {
    context.fillStyle = 'rgb(' + heatColor(x / (canvas.width - 1)).map(Math.round).join(',') + ')';
    context.fillRect(x, 0, 1, canvas.height);
  }
}
