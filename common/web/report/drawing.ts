// Charts as wide as their place, drawn again when that changes: letters keep
// their size on a phone. Colours are the style sheet's, so that light, dark and
// paper need no drawing.

type Draw = (width: number) => Element;

const PAPER_WIDTH = 640;
const drawings: Drawing[] = [];

class Drawing {
  readonly element = document.createElement('div');
  private drawnWidth = 0;

  constructor(private readonly draw: Draw) {
    this.element.className = 'drawing';
    new ResizeObserver(() => this.fit()).observe(this.element);
    drawings.push(this);
  }

  // In a part that is folded up there is no width.
  fit(otherwise = 0): void {
    const width = Math.floor(this.element.clientWidth) || otherwise;
    if (width === 0 || Math.abs(width - this.drawnWidth) < 2) return;
    this.drawnWidth = width;
    this.show();
  }

  private show(): void {
    const chart = this.draw(this.drawnWidth);
    // Observable Plot names its marks as if they had roles: what they show is
    // said by the chart's own label and by the tables.
    for (const mark of chart.querySelectorAll<SVGGElement>('g[aria-label]')) {
      mark.dataset['mark'] = mark.getAttribute('aria-label')!;
      mark.removeAttribute('aria-label');
    }
    this.element.replaceChildren(chart);
  }

  // Whatever it shows has changed.
  redraw(): void {
    if (this.drawnWidth === 0) return;
    this.show();
  }
}

export function drawing(draw: Draw): HTMLElement {
  return new Drawing(draw).element;
}

export function drawingWithRedraw(draw: Draw):
    { element: HTMLElement; redraw: () => void } {
  const made = new Drawing(draw);
  return { element: made.element, redraw: () => made.redraw() };
}

// Paper shows what is folded up, too.
export function prepareForPaper(): void {
  const opened: HTMLDetailsElement[] = [];
  window.addEventListener('beforeprint', () => {
    for (const details of document.querySelectorAll('details')) {
      if (details.open) continue;
      details.open = true;
      opened.push(details);
    }
    for (const each of drawings) each.fit(PAPER_WIDTH);
  });
  window.addEventListener('afterprint', () => {
    for (const details of opened.splice(0)) details.open = false;
  });
}
