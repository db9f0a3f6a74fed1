// The plots below the picture: what the last seconds were like.
'use strict';

class Plot {
  // lines: [{color, of: sample => number}]; top: least height of the axis; mark: where a dashed line stands
  constructor(canvas, lines, top, mark) {
    this.canvas = canvas, this.lines = lines, this.top = top, this.mark = mark;
  }

  draw(samples, seconds) {
    const scale = window.devicePixelRatio || 1, width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (!width || !height) return;
    this.canvas.width = width * scale, this.canvas.height = height * scale;
    const context = this.canvas.getContext('2d');
    context.scale(scale, scale);
    const last = samples.length ? samples[samples.length - 1].time : 0, first = Math.max(0, last - seconds);
    let top = this.top;
    for (const sample of samples) if (sample.time >= first) for (const line of this.lines) top = Math.max(top, 1.08 * line.of(sample));
    const x = time => 40 + (width - 42) * (time - first) / seconds, y = value => height - 3 - (height - 9) * value / top;
    context.font = '10px system-ui, sans-serif', context.fillStyle = '#8d929b', context.textAlign = 'right';
    if (top > 1e-6) context.fillText(shortNumber(top / 1.08), 36, y(top / 1.08) + 4);
    context.fillText('0', 36, height - 1);
    context.strokeStyle = '#3a3e44';
    context.strokeRect(40, 3, width - 42, height - 6);
    if (this.mark !== undefined) {
      context.setLineDash([4, 3]), context.strokeStyle = '#e5604d';
      context.beginPath(), context.moveTo(40, y(this.mark)), context.lineTo(width - 2, y(this.mark)), context.stroke();
      context.setLineDash([]);
    }
    for (const line of this.lines) this.drawLine(context, samples, first, line, x, y);
  }

  drawLine(context, samples, first, line, x, y) {
    context.strokeStyle = line.color, context.lineWidth = 1.5, context.lineJoin = 'round';
    context.beginPath();
    let begun = false;
    for (const sample of samples) {
      if (sample.time < first) continue;
      if (begun) context.lineTo(x(sample.time), y(line.of(sample)));
      else context.moveTo(x(sample.time), y(line.of(sample)));
      begun = true;
    }
    context.stroke();
    context.lineWidth = 1;
  }
}

// "12.3", "4.5 k", "1.2 M"
function shortNumber(value) {
  for (const [size, name] of [[1e9, ' G'], [1e6, ' M'], [1e3, ' k']]) if (Math.abs(value) >= size) return (value / size).toPrecision(3).replace(/\.?0+$/, '') + name;
  return value >= 100 ? value.toFixed(0) : String(Number(value.toPrecision(3)));
}
