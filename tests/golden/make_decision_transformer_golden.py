#!/usr/bin/env python3
"""Writes decision_transformer/*.npy: whole updates of the decision transformer in float64.

Usage: /usr/bin/python3 tests/golden/make_decision_transformer_golden.py   (Debian's python3-torch; the tests need neither)
"""
import math
import numpy as np
import torch
import torch.nn.functional as F
from make_golden import make_parameters, save, tensor, uniform

BATCH, CONTEXT, VEHICLES, HISTORY, UNITS, INNER = 6, 20, 2, 2, 128, 512
STATE = 20 + 7 * VEHICLES


def linear(name, inputs, outputs, bias=True):
    shapes = [(name + '.weight', (inputs, outputs), inputs)]
    return shapes + [(name + '.bias', (outputs,), inputs)] if bias else shapes


def norm(name):
    return [(name + '.gain', (UNITS,), math.inf), (name + '.bias', (UNITS,), math.inf)]


def block(name):
    a = name + '.attention'
    return (norm(name + '.norm1') + linear(a + '.query', UNITS, UNITS) + linear(a + '.key', UNITS, UNITS, False) +
            linear(a + '.value', UNITS, UNITS) + linear(a + '.output', UNITS, UNITS) + norm(name + '.norm2') +
            linear(name + '.inner', UNITS, INNER) + linear(name + '.outer', INNER, UNITS))


SHAPES = ([('place', (CONTEXT, UNITS), 2500)] + linear('return', 1, UNITS) + linear('state', STATE, UNITS) +
          linear('action', 2, UNITS) + norm('norm') + block('block1') + block('block2') + block('block3') +
          norm('last_norm') + linear('output', UNITS, 2))


def dense(p, name, x):
    y = x @ p[name + '.weight']
    return y + p[name + '.bias'] if name + '.bias' in p else y


def layer_norm(p, name, x):
    return F.layer_norm(x, (UNITS,), 1 + p[name + '.gain'], p[name + '.bias'])


def forward(p, states, actions):
    place = p['place']
    tokens = torch.stack([dense(p, 'return', torch.ones(BATCH, CONTEXT, 1)) + place,
                          dense(p, 'state', states) + place, dense(p, 'action', actions) + place], 2)
    x = layer_norm(p, 'norm', tokens.reshape(BATCH, 3 * CONTEXT, UNITS))
    later = torch.ones(3 * CONTEXT, 3 * CONTEXT, dtype=torch.bool).triu(1)
    for i in (1, 2, 3):
        b = f'block{i}.'
        h = layer_norm(p, b + 'norm1', x)
        q, k, v = (dense(p, b + 'attention.' + part, h) for part in ('query', 'key', 'value'))
        score = (q @ k.transpose(1, 2) / math.sqrt(UNITS)).masked_fill(later, -math.inf)
        x = x + dense(p, b + 'attention.output', torch.softmax(score, -1) @ v)
        x = x + dense(p, b + 'outer', F.relu(dense(p, b + 'inner', layer_norm(p, b + 'norm2', x))))
    return torch.tanh(dense(p, 'output', layer_norm(p, 'last_norm', x)[:, 1::3]))


def batch(k):
    """[L + 1, B, ...] as the learner gets them; the state is the newest row of each."""
    ego = uniform(500 + 10 * k, (CONTEXT + 1, BATCH, HISTORY, 20))
    vehicles = uniform(501 + 10 * k, (CONTEXT + 1, BATCH, VEHICLES, HISTORY, 7))
    states = np.concatenate([ego[:-1, :, -1], vehicles[:-1, :, :, -1].reshape(CONTEXT, BATCH, -1)], -1)
    actions = uniform(502 + 10 * k, (CONTEXT, BATCH, 2), 0.99)
    steps = 1 + (np.arange(BATCH) * 7 + k) % CONTEXT
    valid = torch.tensor(np.arange(CONTEXT) < steps[:, None])
    return tensor(states.swapaxes(0, 1)), tensor(actions.swapaxes(0, 1)), valid


if __name__ == '__main__':
    p = make_parameters(3, SHAPES)
    matrices = [v for n, v in p.items() if n.endswith('.weight')]
    others = [v for n, v in p.items() if not n.endswith('.weight')]
    adam = torch.optim.AdamW([{'params': matrices, 'weight_decay': 0.1}, {'params': others, 'weight_decay': 0.0}],
                             lr=1e-3, eps=1e-3)
    losses = []
    for k in range(3):
        states, actions, valid = batch(k)
        # Behind the last step there is nothing; being causal, it does not matter what.
        error = (forward(p, states, actions) - actions)[valid]
        loss = (error ** 2).mean()
        adam.zero_grad(set_to_none=True)
        loss.backward()
        length = torch.nn.utils.clip_grad_norm_(p.values(), 0.25)
        for group in adam.param_groups:
            group['lr'] = 1e-3 * min(1.0, (k + 1) / 2)
        adam.step()
        losses.append([loss.item(), length.item()])
    save('decision_transformer/losses', losses)
    save('decision_transformer/policy', np.concatenate([v.detach().numpy().ravel()[::31] for v in p.values()]))
