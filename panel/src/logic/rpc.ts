/**
 * JSON-RPC 2.0 over one WebSocket. Connects again by itself; whatever was under way when the
 * connection went is told as lost and never sent a second time: nobody knows whether it has moved
 * something already.
 */

export class RpcError extends Error {
  constructor(
    readonly code: number,
    message: string,
    readonly data?: unknown,
  ) {
    super(message);
  }
}

/** Another question of this page came before this one was looked at. */
export const wasOvertaken = (error: unknown): boolean =>
  error instanceof RpcError && (error.data as { code?: string } | null | undefined)?.code === 'overtaken';

/** The connection went, or was not there, or no answer came in time. */
export class ConnectionError extends Error {
  constructor(readonly reason: 'closed' | 'timeout') {
    super(reason);
  }
}

/** As much of a WebSocket as is used here. */
export interface Socket {
  send(text: string): void;
  close(): void;
  onopen: (() => void) | null;
  onclose: (() => void) | null;
  onmessage: ((event: { data: unknown }) => void) | null;
  readonly bufferedAmount: number;
}

export interface RpcOptions {
  connect: () => Socket;
  onOpen: () => void;
  onClose: () => void;
  onMessage: (method: string, params: unknown) => void;
  setTimer?: (callback: () => void, ms: number) => number;
  clearTimer?: (timer: number) => void;
  random?: () => number;
}

interface Waiting {
  resolve: (result: unknown) => void;
  reject: (error: Error) => void;
  timer: number;
}

export const kRetryFirstMs = 250;
export const kRetryMaxMs = 5000;
const kTimeoutMs = 10_000;

export class RpcClient {
  private socket: Socket | null = null;
  private isOpen = false;
  private closed = false;
  private lastId = 0;
  private attempts = 0;
  private retry: number | null = null;
  private readonly waiting = new Map<number, Waiting>();
  private readonly setTimer: (callback: () => void, ms: number) => number;
  private readonly clearTimer: (timer: number) => void;

  constructor(private readonly options: RpcOptions) {
    this.setTimer = options.setTimer ?? ((f, ms) => setTimeout(f, ms) as unknown as number);
    this.clearTimer = options.clearTimer ?? ((timer) => clearTimeout(timer));
  }

  get open(): boolean {
    return this.isOpen;
  }
  /** Bytes that the network has not taken yet. */
  get backlog(): number {
    return this.socket?.bufferedAmount ?? 0;
  }

  start(): void {
    if (this.socket || this.closed) return;
    this.retry = null;
    let socket: Socket;
    try {
      socket = this.options.connect();
    } catch {
      this.again();
      return;
    }
    this.socket = socket;
    socket.onopen = () => {
      this.isOpen = true;
      this.attempts = 0;
      this.options.onOpen();
    };
    socket.onmessage = (event) => this.receive(event.data);
    socket.onclose = () => this.lost(socket);
  }

  /** For good. */
  close(): void {
    this.closed = true;
    if (this.retry !== null) this.clearTimer(this.retry);
    this.socket?.close();
  }

  call<Result = unknown>(
    method: string,
    params: object = {},
    timeoutMs: number = kTimeoutMs,
  ): Promise<Result> {
    const socket = this.socket;
    if (!this.isOpen || !socket) return Promise.reject(new ConnectionError('closed'));
    const id = ++this.lastId;
    return new Promise<Result>((resolve, reject) => {
      const timer = this.setTimer(() => {
        if (this.waiting.delete(id)) reject(new ConnectionError('timeout'));
      }, timeoutMs);
      this.waiting.set(id, { resolve: resolve as (result: unknown) => void, reject, timer });
      socket.send(JSON.stringify({ jsonrpc: '2.0', id, method, params }));
    });
  }

  private receive(data: unknown): void {
    if (typeof data !== 'string') return;
    let message: Record<string, unknown>;
    try {
      message = JSON.parse(data) as Record<string, unknown>;
    } catch {
      return;
    }
    if (typeof message['method'] === 'string') {
      this.options.onMessage(message['method'], message['params']);
      return;
    }
    const waiting = this.waiting.get(message['id'] as number);
    if (!waiting) return;
    this.waiting.delete(message['id'] as number);
    this.clearTimer(waiting.timer);
    const error = message['error'] as { code: number; message: string; data?: unknown } | undefined;
    if (error) waiting.reject(new RpcError(error.code, error.message, error.data));
    else waiting.resolve(message['result']);
  }

  private lost(socket: Socket): void {
    if (this.socket !== socket) return;
    this.socket = null;
    const wasOpen = this.isOpen;
    this.isOpen = false;
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    for (const one of waiting) {
      this.clearTimer(one.timer);
      one.reject(new ConnectionError('closed'));
    }
    if (wasOpen) this.options.onClose();
    this.again();
  }

  private again(): void {
    if (this.closed) return;
    const most = Math.min(kRetryMaxMs, kRetryFirstMs * 2 ** this.attempts++);
    const random = this.options.random ?? Math.random;
    this.retry = this.setTimer(() => this.start(), most * (0.75 + 0.25 * random()));
  }
}
